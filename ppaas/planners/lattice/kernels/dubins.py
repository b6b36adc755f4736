"""Kernel: the shortest curve of a car that only goes forward (Dubins, 1957).

All is in radii, as in `reeds_shepp`, whose words these are too: its first three families with all pieces driven
forward, as they are and with left and right swapped. The middle arc of the third is the long way.
"""

import math

from numba import njit

from ppaas.planners.lattice.kernels.reeds_shepp import MIRROR, SLACK, Word

TURN = 2.0 * math.pi


@njit(cache=True, nogil=True, error_model="numpy")
def _ahead(angle: float) -> float:
    """Bring an angle into [0, 2π); what rounding made of none is none, and not a whole circle."""
    angle -= TURN * math.floor(angle / TURN)
    return angle if 0.0 <= angle <= TURN - SLACK else 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def dubins(x: float, y: float, theta: float, turn: float) -> Word:
    """Return the cheapest word to a goal.

    Parameters
    ----------
    x, y, theta : float
        The goal, from the start [radii, rad].
    turn : float
        What a length weighs on an arc; with 1 the cheapest word is the shortest.
    """
    best = Word(0, 0, 0.0, 0.0, 0.0, math.inf)
    for symmetry in (0, MIRROR):
        gy, phi = (-y, -theta) if symmetry else (y, theta)
        for family in range(3):
            side = -1.0 if family == 1 else 1.0
            a, b = x - side * math.sin(phi), gy - 1.0 + side * math.cos(phi)
            apart, bearing = math.hypot(a, b), math.atan2(b, a)
            if family == 0:
                t, u = _ahead(bearing), apart
                v = _ahead(phi - t)
            elif family == 1 and apart >= 2.0:
                u = math.sqrt(apart * apart - 4.0)
                t = _ahead(bearing + math.atan2(2.0, u))
                v = _ahead(t - phi)
            elif family == 2 and apart <= 4.0:
                back = 2.0 * math.asin(0.25 * apart)
                t, u = _ahead(bearing - 0.5 * back + math.pi), TURN - back
                v = _ahead(phi - t - back)
            else:
                continue
            cost = turn * (t + v) + u * (turn if family == 2 else 1.0)
            if cost < best.cost:
                best = Word(family, symmetry, t, u, v, cost)
    return best


def warm() -> None:
    """Compile and call the kernel once."""
    dubins(1.0, 2.0, 3.0, 1.0)
