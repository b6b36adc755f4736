"""Kernel: shortest curve of a car that drives forward and backward (Reeds and Shepp, 1990).

Lengths are in turning radii: the car turns on circles of radius 1, starts at the origin and faces along x. The 48 words
of the paper are the eight formulas of its section 8 under three symmetries: swapped gears (the goal mirrored in the y
axis), swapped left and right (mirrored in the x axis), and reversed order (from the goal to the start). Formulas 8.3
and 8.4 are misprinted in the paper; here they are one formula.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

QUARTER = 0.5 * math.pi
"""Length of a quarter turn."""
SLACK = 1e-10
"""Tolerance of the signs of lengths: a piece of length zero may come out slightly negative."""

FAMILIES = 8
"""The formulas: L+S+L+, L+S+R+, L+R-L, L+R+L-R-, L+R-L-R+, L+R-S-L-, L+R-S-R-, L+R-S-L-R+. + is forward, - is reverse;
a piece without a sign may be either."""

SWAP_GEARS, MIRROR, BACKWARDS = 1, 2, 4
"""Symmetries, one bit each."""

MAX_PIECES = 5
"""Largest number of pieces of a curve."""


class CurveWord(NamedTuple):
    """A curve: its family and symmetries, the lengths t, u, v of its free pieces [radii], and its cost [radii]."""

    family: int
    symmetry: int
    t: float
    u: float
    v: float
    cost: float


@compiled
def wrap(angle: float) -> float:
    """Wrap an angle to [−π, π)."""
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))


@compiled
def _outer(u: float, w: float, x: float, y: float, phi: float) -> tuple[float, float]:
    """Return the first and last piece of L R L R with the inner pieces ``u`` and ``w`` (formulas 8.5 and 8.6)."""
    difference = wrap(u - w)
    a = math.sin(u) - math.sin(difference)
    b = math.cos(u) - math.cos(difference) - 1.0
    t = math.atan2(y * a - x * b, x * a + y * b)
    if 2.0 * (math.cos(difference) - math.cos(w) - math.cos(u)) + 3.0 < 0.0:
        t += math.pi
    t = wrap(t)
    return t, wrap(t - u + w - phi)


@compiled
def _solve(
    family: int, a: float, b: float, apart: float, bearing: float, phi: float, most: float
) -> tuple[bool, float, float, float]:
    """Solve one family for the lengths of its pieces (section 8 of the paper).

    Parameters
    ----------
    family : int
        Index in `FAMILIES`.
    a, b : float
        Centre of the last circle, relative to that of the first one [radii].
    apart, bearing : float
        The same in polar coordinates [radii, rad].
    phi : float
        Heading at the goal [rad].
    most : float
        Solutions whose length is at least this are skipped.

    Returns
    -------
    found : bool
        Whether there is a solution.
    t, u, v : float
        Lengths of the free pieces, negative in reverse.
    """
    t, u, v, found = 0.0, 0.0, 0.0, False
    if family == 0:
        if apart < most:
            t, u, v = bearing, apart, wrap(phi - bearing)
            found = t >= -SLACK and v >= -SLACK
    elif family == 2:
        if 0.5 * apart < min(most, 2.0 + SLACK):
            u = -2.0 * math.asin(min(1.0, 0.25 * apart))
            t = wrap(bearing + 0.5 * u + math.pi)
            v = wrap(phi - t + u)
            found = t >= -SLACK
    elif family == 3:
        u = math.acos(min(1.0, 0.25 * (2.0 + apart)))
        if apart <= 2.0 and 2.0 * u < most:
            t, v = _outer(u, -u, a, b, phi)
            found = t >= -SLACK and v <= SLACK
    elif family == 4:
        cosine = (20.0 - apart * apart) / 16.0
        if 0.0 <= cosine <= 1.0:
            u = -math.acos(cosine)
            if -2.0 * u < most:
                t, v = _outer(u, u, a, b, phi)
                found = t >= -SLACK and v >= -SLACK
    elif family == 6:
        if 2.0 - SLACK <= apart < most + 2.0 - QUARTER:
            t, u = wrap(bearing + QUARTER), 2.0 - apart
            v = wrap(t + QUARTER - phi)
            found = t >= -SLACK and v <= SLACK
    elif apart >= 2.0:  # families 1, 5 and 7: the straight piece is an inner tangent of the circles
        straight = math.sqrt(apart * apart - 4.0)
        if straight - 4.0 + math.pi < most:
            t = wrap(bearing + math.atan2(2.0, straight) + (0.0 if family == 1 else QUARTER))
            if family == 1:
                u, v = straight, wrap(t - phi)
                found = t >= -SLACK and v >= -SLACK
            elif family == 5:
                u, v = 2.0 - straight, wrap(phi - QUARTER - t)
                found = t >= -SLACK and u <= SLACK and v <= SLACK
            else:
                u, v = 4.0 - straight, wrap(t - phi)
                found = t >= -SLACK and u <= SLACK and v >= -SLACK
    return found, t, u, v


@compiled
def _cost(family: int, t: float, u: float, v: float, flipped: bool, reverse: float, turn: float) -> float:
    """Return the cost of a word: lengths weigh ``turn`` times as much on an arc, and ``reverse`` times in reverse.

    ``flipped`` tells that the gears are swapped.
    """
    ahead, back = (reverse, 1.0) if flipped else (1.0, reverse)
    cost = turn * (abs(t) * (ahead if t > 0.0 else back) + abs(v) * (ahead if v > 0.0 else back))
    middle = abs(u) * (ahead if u > 0.0 else back)
    if family in (0, 1):
        return cost + middle
    if family == 2:
        return cost + turn * middle
    if family == 3:
        return cost + turn * abs(u) * (1.0 + reverse)
    if family == 4:
        return cost + 2.0 * turn * middle
    return cost + middle + turn * QUARTER * back * (2.0 if family == 7 else 1.0)


@compiled
def reeds_shepp(x: float, y: float, theta: float, reverse: float, turn: float) -> CurveWord:
    """Return the cheapest word to a goal.

    Parameters
    ----------
    x, y, theta : float
        The goal in the frame of the start [radii, rad].
    reverse, turn : float
        Factors on the length driven in reverse, and on arcs; with 1 and 1 the cheapest word is the shortest.
    """
    best = CurveWord(0, 0, 0.0, 0.0, 0.0, math.inf)
    sine, cosine = math.sin(theta), math.cos(theta)
    for symmetry in range(8):
        backwards, swapped, mirrored = symmetry & BACKWARDS, symmetry & SWAP_GEARS, symmetry & MIRROR
        gx, gy = (x * cosine + y * sine, x * sine - y * cosine) if backwards else (x, y)
        if swapped:
            gx = -gx
        if mirrored:
            gy = -gy
        turned = bool(swapped) != bool(mirrored)
        phi, side = wrap(-theta if turned else theta), -sine if turned else sine
        for same in (True, False):  # whether the last arc is a left turn, like the first
            a, b = (gx - side, gy - 1.0 + cosine) if same else (gx + side, gy - 1.0 - cosine)
            apart, bearing = math.hypot(a, b), math.atan2(b, a)
            for family in range(FAMILIES):
                if same != (family in (0, 2, 5)):
                    continue
                if backwards and family not in (2, 5, 6):  # reversing the others only yields words covered above
                    continue
                found, t, u, v = _solve(family, a, b, apart, bearing, phi, best.cost)
                if found:
                    cost = _cost(family, t, u, v, swapped != 0, reverse, turn)
                    if cost < best.cost:
                        best = CurveWord(family, symmetry, t, u, v, cost)
    return best


@compiled
def spell(word: CurveWord, pieces: NDArray[np.float64]) -> int:
    """Write the pieces of a word, and return their number.

    Parameters
    ----------
    word : CurveWord
    pieces : (MAX_PIECES, 2) float64 array
        Out: curvature (1 left, 0 straight, −1 right) and length, negative in reverse [radii].
    """
    quarter, family, u = -QUARTER, word.family, word.u
    pieces[0, 0], pieces[0, 1] = 1.0, word.t
    count = 3 if family < 3 else 4 if family < 7 else 5
    if family < 3:
        pieces[1, 0], pieces[1, 1] = (-1.0 if family == 2 else 0.0), u
    else:
        pieces[1, 0], pieces[1, 1] = -1.0, (u if family < 5 else quarter)
        pieces[2, 0], pieces[2, 1] = (1.0 if family < 5 else 0.0), (-u if family == 3 else u)
    if family == 7:
        pieces[3, 0], pieces[3, 1] = 1.0, quarter
    pieces[count - 1, 0] = 1.0 if family in (0, 2, 5) else -1.0
    pieces[count - 1, 1] = word.v
    for piece in range(count):
        if word.symmetry & SWAP_GEARS:
            pieces[piece, 1] = -pieces[piece, 1]
        if word.symmetry & MIRROR:
            pieces[piece, 0] = -pieces[piece, 0]
    if word.symmetry & BACKWARDS:
        for piece in range(count // 2):
            other = count - 1 - piece
            for part in range(2):
                pieces[piece, part], pieces[other, part] = pieces[other, part], pieces[piece, part]
    return count


def warm() -> None:
    """Compile and call each kernel once."""
    spell(reeds_shepp(1.0, 2.0, 3.0, 1.0, 1.0), np.empty((MAX_PIECES, 2)))
