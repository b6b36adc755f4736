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
