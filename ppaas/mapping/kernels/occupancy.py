"""Kernels: counts of the beams that pass and that end in each cell of a map."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.maps.kernels.traversal import FRACTION, ahead, cell_at, crossings, to_fixed

MOST = np.uint16(65535)
"""Highest count."""


@compiled(inline="always")
def _add(counts: NDArray[np.uint16], cell: int) -> None:
    """Count one beam more in a cell; the highest count stays."""
    counts[cell] = min(counts[cell], MOST - np.uint16(1)) + np.uint16(1)


@compiled
def _pass_lines(
    passed: NDArray[np.uint16],
    index: int,
    stride: int,
    side: float,
    slope: float,
    side_stride: int,
    size: int,
    count: int,
    end: int,
) -> None:
    """Count a beam in the cells behind its crossings with the lines of one axis, except in its last cell.

    Parameters
    ----------
    passed : (height · width,) uint16 array
        Modified: numbers of beams.
    index : int
        Index of the cell behind the first crossing, at position 0 of the other axis.
    stride : int
        Difference of indices between two crossings.
    side, slope : float
        Position on the other axis at the first crossing, and its change from each crossing to the next [cells].
    side_stride, size : int
        Difference of indices between two cells along the other axis, and their number.
    count : int
        Number of crossings.
    end : int
        Index of the last cell.
    """
    position, move = ahead(side, slope), to_fixed(slope)
    for i in range(count):
        cell = position >> FRACTION
        entered = index + i * stride + cell * side_stride
        if 0 <= cell < size and entered != end:
            _add(passed, entered)
        position += move


@compiled
def _pass_beam(
    passed: NDArray[np.uint16], height: int, width: int, x: float, y: float, to_x: float, to_y: float
) -> None:
    """Count a beam between two points of the grid [cells] in all cells before the one that it ends in."""
    length = math.hypot(to_x - x, to_y - y)
    if length == 0.0:
        return
    dx, dy = (to_x - x) / length, (to_y - y) / length
    row, column = cell_at(y, height), cell_at(x, width)
    end = cell_at(to_y, height) * width + cell_at(to_x, width)
    if row * width + column != end:
        _add(passed, row * width + column)
    # Cells behind crossings with vertical lines, then with horizontal ones.
    count, first, spacing = crossings(x, dx, column, width, length)
    step = 1 if dx > 0.0 else -1
    _pass_lines(passed, column + step, step, y + first * dy, spacing * dy, width, height, count, end)
    count, first, spacing = crossings(y, dy, row, height, length)
    step = 1 if dy > 0.0 else -1
    _pass_lines(passed, (row + step) * width, step * width, x + first * dx, spacing * dx, 1, width, count, end)


@compiled
def bounds(
    poses: NDArray[np.float64], points: NDArray[np.float32], valid: NDArray[np.bool_]
) -> tuple[float, float, float, float]:
    """Return the least x and y and the greatest x and y [m] of all poses and points; see `count_beams`."""
    x0, y0, x1, y1 = np.inf, np.inf, -np.inf, -np.inf
    for k in range(poses.shape[0]):
        c, s = math.cos(poses[k, 2]), math.sin(poses[k, 2])
        x0, y0, x1, y1 = min(x0, poses[k, 0]), min(y0, poses[k, 1]), max(x1, poses[k, 0]), max(y1, poses[k, 1])
        for b in range(points.shape[1]):
            if valid[k, b]:
                x = c * points[k, b, 0] - s * points[k, b, 1] + poses[k, 0]
                y = s * points[k, b, 0] + c * points[k, b, 1] + poses[k, 1]
                x0, y0, x1, y1 = min(x0, x), min(y0, y), max(x1, x), max(y1, y)
    return x0, y0, x1, y1


@compiled
def count_beams(
    ended: NDArray[np.uint16],
    passed: NDArray[np.uint16],
    x0: float,
    y0: float,
    resolution: float,
    poses: NDArray[np.float64],
    points: NDArray[np.float32],
    valid: NDArray[np.bool_],
) -> None:
    """Count the beams of key frames in the cells that they pass and in those that they end in.

    Parameters
    ----------
    ended, passed : (height, width) uint16 array
        Modified: numbers of beams; a beam does not pass the cell that it ends in.
    x0, y0 : float
        Corner of cell (0, 0) in the map frame [m]; all beams lie in the grid.
    resolution : float
        Edge of a cell [m].
    poses : (k, 3) float64 array
        Poses of the laser in the map frame: x, y [m], theta [rad].
    points : (k, b, 2) float32 array
        Ends of the beams, each in the frame of its laser [m].
    valid : (k, b) bool array
        Whether the beam has a reading.
    """
    height, width = ended.shape
    ends, passes = ended.reshape(ended.size), passed.reshape(passed.size)
    for k in range(poses.shape[0]):
        c, s = math.cos(poses[k, 2]), math.sin(poses[k, 2])
        x, y = (poses[k, 0] - x0) / resolution, (poses[k, 1] - y0) / resolution
        for b in range(points.shape[1]):
            if valid[k, b]:
                to_x = x + (c * points[k, b, 0] - s * points[k, b, 1]) / resolution
                to_y = y + (s * points[k, b, 0] + c * points[k, b, 1]) / resolution
                _pass_beam(passes, height, width, x, y, to_x, to_y)
                _add(ends, cell_at(to_y, height) * width + cell_at(to_x, width))


def warm() -> None:
    """Call the kernels once, so that they are compiled or loaded from the cache."""
    cells, poses = np.zeros((1, 1), np.uint16), np.zeros((1, 3))
    points, valid = np.zeros((1, 1, 2), np.float32), np.ones((1, 1), np.bool_)
    bounds(poses, points, valid)
    count_beams(cells, cells, 0.0, 0.0, 1.0, poses, points, valid)
