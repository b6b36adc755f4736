"""Kernels: clearance between a robot's outline and obstacles, from a distance field.

Coordinates are in the frame of the grid: metres from the corner of cell (0, 0), x along the rows.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

Floats = NDArray[np.float64]
Field = NDArray[np.float32]

REACH = 0.35
"""Clearance of the circumscribed circle above which the edges of the outline are not examined [m]."""

LEAST_STEP = 0.5
"""Smallest distance between two samples of an edge [cells]."""


class RobotOutline(NamedTuple):
    """Outline of a robot.

    Parameters
    ----------
    edges : (n, 5) array
        Edges of the outline, none for a disc: x, y of a corner [m], unit direction to the next one, and length [m].
    inscribed, circumscribed : float
        Radii of the inscribed and circumscribed circle around the robot's origin [m].
    """

    edges: Floats
    inscribed: float
    circumscribed: float


@compiled(inline="always")
def bilinear(field: Field, column: float, row: float) -> float:
    """Return the value of a field at a point [cells] by bilinear interpolation between the centres of cells.

    Outside the outermost centres, the value is that of the nearest edge.
    """
    height, width = field.shape
    column = min(max(column - 0.5, 0.0), width - 1.0)
    row = min(max(row - 0.5, 0.0), height - 1.0)
    c, r = min(int(column), max(width - 2, 0)), min(int(row), max(height - 2, 0))
    right, up = column - c, row - r
    d, e = min(c + 1, width - 1), min(r + 1, height - 1)
    low = field[r, c] + right * (field[r, d] - field[r, c])
    high = field[e, c] + right * (field[e, d] - field[e, c])
    return float(low + up * (high - low))


@compiled
def clearance(
    distance: Field, resolution: float, body: RobotOutline, x: float, y: float, cosine: float, sine: float
) -> float:
    """Return the distance from the outline to the centre of the nearest occupied cell [m].

    It is 0 or less if that centre is within the inscribed circle. For a centre between that circle and the outline it
    is the distance to the outline or to the circle, whichever is less: the obstacle must have crossed the outline.

    Parameters
    ----------
    distance : (h, w) float32 array
        Distance from each cell's centre to that of the nearest occupied cell [m].
    resolution : float
        Edge of a cell [m].
    body : RobotOutline
        Outline of the robot.
    x, y, cosine, sine : float
        Pose of the robot: position [m], cosine and sine of the heading.
    """
    edges, per = body.edges, 1.0 / resolution
    # The two circles decide most cases.
    here = bilinear(distance, x * per, y * per)
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
        # Steps are as long as the distance d found: every point of a step is at least 0.87 d from all obstacles.
        while along < length:
            found = bilinear(distance, column + along * right, row + along * up)
            nearest = min(nearest, found)
            along += max(found, least)
    return nearest


@compiled
def clearance_along(
    distance: Field,
    resolution: float,
    body: RobotOutline,
    start: tuple[float, float, float],
    motion: tuple[float, float],
) -> float:
    """Return the smallest clearance on an arc, including its start [m].

    Parameters
    ----------
    distance : (h, w) float32 array
        Distance from each cell's centre to that of the nearest occupied cell [m].
    resolution : float
        Edge of a cell [m]; no point of the robot moves farther between two samples of the arc.
    body : RobotOutline
        Outline of the robot.
    start : (x, y, theta)
        Pose at the start, in the frame of the grid [m, rad].
    motion : (length, turn)
        Length of the arc, negative in reverse [m], and its turn [rad].
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
    """Call each kernel once, so that it is compiled or loaded from the cache."""
    ground, disc = np.ones((2, 2), np.float32), RobotOutline(np.zeros((0, 5)), 0.18, 0.18)
    clearance(ground, 0.05, disc, 0.0, 0.0, 1.0, 0.0)
    clearance_along(ground, 0.05, disc, (0.0, 0.0, 0.0), (0.1, 0.1))
