"""Position along a plan and the plan ahead, by numpy: the slow twin of `ppaas.controllers.kernels.followed_path`."""

import numpy as np
from numpy.typing import NDArray

from ppaas.controllers.kernels.followed_path import LOST, MOST_POINTS, SEARCH_AHEAD, SPACING
from ppaas.maps.grid import GridInfo

Floats = NDArray[np.float64]


def locate(points: Floats, along: Floats, reached: int, x: float, y: float) -> int:
    """Return the index of the point at which a robot is, after it was at ``reached``."""

    def nearest(first: int, last: int) -> tuple[int, float]:
        distances = np.hypot(points[first:last, 0] - x, points[first:last, 1] - y)
        found = int(np.argmin(distances))
        return first + found, float(distances[found])

    before, distance = -1, 0.0
    while reached > before:
        before = reached
        last = int(np.searchsorted(along, along[before] + SEARCH_AHEAD, side="right"))
        reached, distance = nearest(before, last)
    return nearest(0, len(points))[0] if distance > LOST else reached


def point_at(points: Floats, along: Floats, s: float) -> tuple[float, float]:
    """Return the point at a distance from the first, along the plan."""
    return float(np.interp(s, along, points[:, 0])), float(np.interp(s, along, points[:, 1]))


def points_ahead(points: Floats, along: Floats, reached: int, distance: float, info: GridInfo) -> tuple[Floats, Floats]:
    """Return the points ahead within a grid, and the distance from each to the last."""
    first, last = max(0.0, along[reached] - SPACING), min(along[-1], along[reached] + distance)
    s = np.linspace(first, last, min(MOST_POINTS, 2 + int((last - first) / SPACING)))
    ahead = np.stack([np.interp(s, along, points[:, axis]) for axis in (0, 1)], axis=-1)
    cells = info.to_cells(ahead)
    outside = ((cells < 0) | (cells >= info.shape)).any(axis=1)
    inside = max(1, int(np.argmax(outside)) if outside.any() else len(s))
    return ahead[:inside], s[inside - 1] - s[:inside]
