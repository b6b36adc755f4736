"""Kernel: shortest curve of a car that drives forward only (Dubins, 1957).

Lengths are in turning radii, as in `reeds_shepp`. The result uses its words: families 0 to 2 (LSL, LSR, LRL) with all
pieces driven forward, plain and mirrored (RSR, RSL, RLR). The middle arc of LRL and RLR is longer than π.
"""

import math

from ppaas.kernel_cache.decorators import compiled
from ppaas.planners.lattice.kernels.reeds_shepp import MIRROR, SLACK, CurveWord

TURN = 2.0 * math.pi


@compiled
def _ahead(angle: float) -> float:
    """Wrap an angle to [0, 2π); within `SLACK` below 2π it becomes 0, so that rounding does not add a full circle."""
    angle -= TURN * math.floor(angle / TURN)
    return angle if 0.0 <= angle <= TURN - SLACK else 0.0


@compiled
def dubins(x: float, y: float, theta: float, turn: float) -> CurveWord:
    """Return the cheapest word to a goal.

    Parameters
    ----------
    x, y, theta : float
        The goal in the frame of the start [radii, rad].
    turn : float
        Factor on the length of arcs; with 1 the cheapest word is the shortest.
    """
    best = CurveWord(0, 0, 0.0, 0.0, 0.0, math.inf)
    for symmetry in (0, MIRROR):
        gy, phi = (-y, -theta) if symmetry else (y, theta)
        for family in range(3):
            side = -1.0 if family == 1 else 1.0
            # a, b: from the centre of the first circle, on the left of the start, to that of the last one.
            a, b = x - side * math.sin(phi), gy - 1.0 + side * math.cos(phi)
            apart, bearing = math.hypot(a, b), math.atan2(b, a)
            # t, u, v: lengths of the first, middle and last piece.
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
                best = CurveWord(family, symmetry, t, u, v, cost)
    return best


def warm() -> None:
    """Compile and call the kernel once."""
    dubins(1.0, 2.0, 3.0, 1.0)
