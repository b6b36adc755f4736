"""Kernels: position of a robot along the plan that it follows, and the part of the plan ahead of it."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

Floats = NDArray[np.float64]

SEARCH_AHEAD = 1.0
"""Length of the plan ahead of the last position in which the robot is searched, so that no loop is skipped [m]."""

LOST = 1.0
"""Distance from the plan above which the robot is searched along the whole plan [m]."""

SPACING = 0.05
"""Distance between the points ahead [m], larger if there would be more than `MOST_POINTS`."""

MOST_POINTS = 64


@compiled
def _nearest(points: Floats, x: float, y: float, first: int, last: int) -> tuple[int, float]:
    nearest, least = first, math.inf
    for i in range(first, last):
        distance = math.hypot(points[i, 0] - x, points[i, 1] - y)
        if distance < least:
            nearest, least = i, distance
    return nearest, least


@compiled
def locate(points: Floats, along: Floats, reached: int, x: float, y: float) -> int:
    """Return the index of the point of a plan at which a robot is.

    It is searched ahead of the last one, and on the whole plan if that fails.

    Parameters
    ----------
    points : (n, 2) array
        x, y [m].
    along : (n,) array
        Distance of each point from the first, along the plan [m].
    reached : int
        Index of the point at which the robot was.
    x, y : float
        Position of the robot [m].
    """
    before, distance = -1, 0.0
    while reached > before:
        before = reached
        last = np.searchsorted(along, along[before] + SEARCH_AHEAD, side="right")
        reached, distance = _nearest(points, x, y, before, last)
    if distance > LOST:
        reached, _ = _nearest(points, x, y, 0, len(points))
    return reached


@compiled
def point_at(points: Floats, along: Floats, s: float) -> tuple[float, float]:
    """Return the point of a plan at a distance ``s`` from its first, along the plan, as ``numpy.interp`` does [m]."""
    last = len(along) - 1
    j = int(np.searchsorted(along, s, side="right")) - 1
    if j < 0:
        return points[0, 0], points[0, 1]
    if j >= last or along[j] == s:
        return points[j, 0], points[j, 1]
    way, rest = along[j + 1] - along[j], s - along[j]
    x = (points[j + 1, 0] - points[j, 0]) / way * rest + points[j, 0]
    y = (points[j + 1, 1] - points[j, 1]) / way * rest + points[j, 1]
    return x, y


@compiled
def points_ahead(
    points: Floats, along: Floats, reached: int, distance: float,
    origin: tuple[float, float, float], resolution: float, shape: tuple[int, int],
) -> tuple[Floats, Floats]:  # fmt: skip
    """Return a plan from a robot to a distance ahead, or to the edge of a costmap.

    Parameters
    ----------
    points, along, reached
        See `locate`.
    distance : float
        Length of the part ahead [m].
    origin : tuple of float
        x, y [m], theta [rad] of the corner of the costmap.
    resolution : float
        Edge of a cell [m].
    shape : tuple of int
        Height and width of the costmap [cells].

    Returns
    -------
    ahead : (m, 2) array
        x, y [m], evenly spaced.
    remaining : (m,) array
        Distance from each point to the last, along the plan [m].
    """
    first = max(0.0, along[reached] - SPACING)
    last = min(along[-1], along[reached] + distance)
    count = min(MOST_POINTS, 2 + int((last - first) / SPACING))
    step = (last - first) / (count - 1)
    cosine, sine = math.cos(origin[2]), math.sin(origin[2])
    ahead, s = np.empty((count, 2)), np.empty(count)
    inside = 0
    for i in range(count):
        s[i] = last if i == count - 1 else i * step + first
        ahead[i, 0], ahead[i, 1] = point_at(points, along, s[i])
        dx, dy = ahead[i, 0] - origin[0], ahead[i, 1] - origin[1]
        column, row = (cosine * dx + sine * dy) / resolution, (cosine * dy - sine * dx) / resolution
        if not (0.0 <= row < shape[0] and 0.0 <= column < shape[1]):
            break
        inside += 1
    inside = max(inside, 1)
    return ahead[:inside], s[inside - 1] - s[:inside]


def warm() -> None:
    """Call each kernel once."""
    points, along = np.zeros((2, 2)), np.zeros(2)
    locate(points, along, 0, 0.0, 0.0)
    point_at(points, along, 0.0)
    points_ahead(points, along, 0, 1.0, (0.0, 0.0, 0.0), 1.0, (2, 2))
