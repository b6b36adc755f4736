"""Patches of depth images: relief of a surface in metric cells, independent of its distance.

As in "Real-time RGB-D based people detection and tracking" (Jafari, Mitzel and Leibe, ICRA 2014), depths are relative
to the surface. Here the cells have a size in metres, and each is one of a few steps of depth, so that pixels without a
reading or outside the image have separate steps.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.perception.torso.floor_view import FloorPoints, FloorView

COLUMNS, ROWS = 16, 43
"""Number of cells across and upwards."""

COLUMN_WIDTH, ROW_HEIGHT, LOWEST = 0.0625, 0.05, 0.1
"""Size of a cell, and the height of the lowest [m]."""

EDGES = np.array([-0.35, -0.15, -0.05, 0.05, 0.15, 0.35], np.float32)
"""Limits of the steps of depth behind the surface [m]."""

OUTSIDE, NO_READING, FIRST = 0, 1, 2
"""Steps of cells outside the image and without a reading, and the first step of depth."""

STEPS = FIRST + len(EDGES) + 1
"""Number of steps."""

_ACROSS = ((np.arange(COLUMNS) - (COLUMNS - 1) / 2) * COLUMN_WIDTH).astype(np.float32)
_HEIGHTS = (LOWEST + np.arange(ROWS) * ROW_HEIGHT).astype(np.float32)


def patches_at(view: FloorView, points: FloorPoints, places: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return the patches of surfaces, (n, `ROWS`, `COLUMNS`) uint8: steps, from the floor upwards, from right to left.

    Parameters
    ----------
    view : FloorView
        View of the camera.
    points : FloorPoints
        Points of its image.
    places : (n, 2) float32 array
        Centres of the surfaces over the floor [m].
    """
    x, y = places.T
    ahead_x, ahead_y = x - np.float32(view.origin[0]), y - np.float32(view.origin[1])
    distance = np.hypot(ahead_x, ahead_y)
    ahead_x, ahead_y = ahead_x / distance, ahead_y / distance
    cells_x = (x[:, None] - ahead_y[:, None] * _ACROSS)[:, None, :]
    cells_y = (y[:, None] + ahead_x[:, None] * _ACROSS)[:, None, :]
    index, inside = view.pixels(cells_x, cells_y, _HEIGHTS[None, :, None])
    behind = np.take(points.x, index)
    behind *= ahead_x[:, None, None]
    behind += np.take(points.y, index) * ahead_y[:, None, None]
    behind -= (x * ahead_x + y * ahead_y)[:, None, None]
    steps = np.full(behind.shape, FIRST, np.uint8)
    for edge in EDGES:
        steps += behind > edge
    steps[np.isnan(behind)] = NO_READING
    steps[~inside] = OUTSIDE
    return steps


LOW, HIGH = 0.75, 1.35
"""Heights between which standing and sitting people have chest, neck or head [m]."""

CELL_AHEAD, CELL_ACROSS = 0.10, 0.06
"""Size of a cell of the plan view, along and across the robot's heading [m]."""

LEAST_HEIGHT = 0.12
"""Least height of the surface over a cell, measured by the area of its pixels [m]."""


def propose(view: FloorView, points: FloorPoints, range_min: float, range_max: float) -> NDArray[np.float32]:
    """Return the centres of upright surfaces, (n, 2) float32: x, y over the floor [m].

    Of the cells of a surface that is thicker than a cell, only the one with the largest area is returned.

    Parameters
    ----------
    view : FloorView
        View of the camera.
    points : FloorPoints
        Points of its image.
    range_min, range_max : float
        Limits of the distance from the camera [m].
    """
    x, y, z = (axis[::2, ::2].ravel() for axis in points)
    ox, oy = view.origin[:2].astype(np.float32)
    with np.errstate(invalid="ignore"):
        kept = np.flatnonzero((z > LOW) & (z < HIGH) & (np.hypot(x - ox, y - oy) < range_max))
    x, y = x[kept], y[kept]
    distance = np.hypot(x - ox, y - oy)
    kept = distance > range_min
    x, y, distance = x[kept], y[kept], distance[kept]
    if not len(x):
        return np.empty((0, 2), np.float32)
    pixel = (2.0 * view.stride) ** 2 / (view.camera.fx * view.fy)
    area = distance * distance * np.float32(pixel)
    # One empty cell around all points, so that neighbours of a cell are always in the grid.
    i = ((x - x.min()) / np.float32(CELL_AHEAD)).astype(np.int64) + 1
    k = ((y - y.min()) / np.float32(CELL_ACROSS)).astype(np.int64) + 1
    shape = int(i.max()) + 2, int(k.max()) + 2
    flat = i * shape[1] + k
    sums = [np.bincount(flat, weight, shape[0] * shape[1]).reshape(shape) for weight in (area, area * x, area * y)]
    thick = [each.copy() for each in sums]
    for each, one in zip(thick, sums, strict=True):
        each[1:] += one[:-1]
        each[:-1] += one[1:]
    total = thick[0]
    largest = total >= LEAST_HEIGHT * CELL_ACROSS
    largest[1:] &= total[1:] >= total[:-1]
    largest[:-1] &= total[:-1] > total[1:]
    return np.stack([each[largest] / total[largest] for each in thick[1:]], 1).astype(np.float32)
