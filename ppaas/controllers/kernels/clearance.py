"""Kernels: how far a robot's outline is from what it may not touch, in a field of distances.

All in the frame of the grid: metres from the corner of cell (0, 0), along its rows.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Field = NDArray[np.float32]

REACH = 0.35
"""Farther than this from its outer circle, a robot's outline need not be looked at [m]."""
LEAST_STEP = 0.5
"""Closest that two looks at the outline are [cells]."""


class Body(NamedTuple):
    """The robot's outline: its edges, none for a disc, and the radii of its inner and outer circle [m].

    A row of the (n, 5) edges is a corner, the direction to the next one, and how far that is.
    """

    edges: Floats
    inscribed: float
    circumscribed: float


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def between(field: Field, column: float, row: float) -> float:
    """Return a value between the middles of cells; beyond the edge, that of the edge."""
    height, width = field.shape
    column = min(max(column - 0.5, 0.0), width - 1.0)
    row = min(max(row - 0.5, 0.0), height - 1.0)
    c, r = min(int(column), max(width - 2, 0)), min(int(row), max(height - 2, 0))
    right, up = column - c, row - r
    d, e = min(c + 1, width - 1), min(r + 1, height - 1)
    low = field[r, c] + right * (field[r, d] - field[r, c])
    high = field[e, c] + right * (field[e, d] - field[e, c])
    return float(low + up * (high - low))


@njit(cache=True, nogil=True, error_model="numpy")
def clearance(distance: Field, resolution: float, body: Body, x: float, y: float, cosine: float, sine: float) -> float:
    """Return the distance from the outline to the nearest obstacle's middle [m].

    It is 0 or less where a middle lies within the inscribed circle. Of one between the circle and the outline it is how
    far that is from the outline or from the circle, whichever is less: to get there it came through the outline.
    """
    edges, per = body.edges, 1.0 / resolution
    here = between(distance, x * per, y * per)
    if len(edges) == 0 or here > body.circumscribed + REACH:
        return here - body.circumscribed
    nearest = here - body.inscribed
    if nearest <= 0.0:
        return nearest
    least = LEAST_STEP * resolution
    for i in range(len(edges)):
        ax, ay, ux, uy, length = edges[i, 0], edges[i, 1], edges[i, 2], edges[i, 3], edges[i, 4]
        column, row = (x + cosine * ax - sine * ay) * per, (y + sine * ax + cosine * ay) * per
        right, up = (cosine * ux - sine * uy) * per, (sine * ux + cosine * uy) * per
        along = 0.0
        # What is as far as d from both ends of a step of d is at least 0.87 d from all between.
        while along < length:
            found = between(distance, column + along * right, row + along * up)
            nearest = min(nearest, found)
            along += max(found, least)
    return nearest


@njit(cache=True, nogil=True, error_model="numpy")
def clearance_along(
    distance: Field, resolution: float, body: Body, start: tuple[float, float, float], motion: tuple[float, float]
) -> float:
    """Return the least clearance on an arc, the start included [m].

    Parameters
    ----------
    distance : (h, w) array
        To obstacles [m].
    resolution : float
        Edge of a cell [m]. No point of the robot goes farther between two looks at it.
    body : Body
    start : (x, y, theta)
        In the frame of the grid [m, rad].
    motion : (length, turn)
        How far along the arc it goes, backwards if that is negative [m], and by how much it turns [rad].
    """
    x, y, theta = start
    length, turn = motion
    farthest = max(abs(length) + body.circumscribed * abs(turn), resolution)
    steps = math.ceil(farthest / resolution)
    step, half = length / steps, 0.5 * turn / steps
    cosine, sine = math.cos(theta), math.sin(theta)
    c, s = math.cos(half), math.sin(half)
    chord = step * (s / half if abs(half) > 1e-9 else 1.0)
    least = clearance(distance, resolution, body, x, y, cosine, sine)
    for _ in range(steps):
        cosine, sine = c * cosine - s * sine, s * cosine + c * sine
        x += chord * cosine
        y += chord * sine
        cosine, sine = c * cosine - s * sine, s * cosine + c * sine
        least = min(least, clearance(distance, resolution, body, x, y, cosine, sine))
    return least


def warm() -> None:
    """Compile and call each kernel once."""
    ground, disc = np.ones((2, 2), np.float32), Body(np.zeros((0, 5)), 0.18, 0.18)
    clearance(ground, 0.05, disc, 0.0, 0.0, 1.0, 0.0)
    clearance_along(ground, 0.05, disc, (0.0, 0.0, 0.0), (0.1, 0.1))
