"""Marking and clearing by laser rays, as costmap_2d's obstacle layer does it."""

import math

import numpy as np
from numba import njit, types
from numpy.typing import NDArray

from ppaas.cost_values import FREE_SPACE, LETHAL_OBSTACLE
from ppaas.maps.kernels.traversal import FRACTION, ahead, cell_at, clip_axis, crossings, to_fixed

_CELLS = types.uint8[:, ::1]
_NUMBERS = types.Array(types.float64, 1, "C", readonly=True)
_FLOAT = types.float64

_INSIDE = 0.02
"""What was hit begins at the range: its cell is looked up so far behind, lest rounding take the one before [cells]."""


@njit(cache=True, nogil=True, error_model="numpy")
def _free(
    flat: NDArray[np.uint8],
    index: int,
    stride: int,
    side: float,
    slope: float,
    side_stride: int,
    size: int,
    count: int,
    keep: int,
) -> None:
    """Set the cells free that ``count`` crossings lead into, but not ``keep``."""
    position, move = ahead(side, slope), to_fixed(slope)
    for i in range(count):
        cell = position >> FRACTION
        entered = index + i * stride + cell * side_stride
        if 0 <= cell < size and entered != keep:
            flat[entered] = FREE_SPACE
        position += move


@njit(cache=True, nogil=True, error_model="numpy")
def _clear(cells: NDArray[np.uint8], x: float, y: float, dx: float, dy: float, far: float, keep: int) -> None:
    height, width = cells.shape
    near, end = clip_axis(x, dx, width, 0.0, far)
    near, end = clip_axis(y, dy, height, near, end)
    if near > end:
        return
    row, column = cell_at(y + near * dy, height), cell_at(x + near * dx, width)
    flat = cells.reshape(cells.size)
    if row * width + column != keep:
        cells[row, column] = FREE_SPACE
    count, first, spacing = crossings(x, dx, column, width, end)
    step = 1 if dx > 0.0 else -1
    _free(flat, column + step, step, y + first * dy, spacing * dy, width, height, count, keep)
    count, first, spacing = crossings(y, dy, row, height, end)
    step = 1 if dy > 0.0 else -1
    _free(flat, (row + step) * width, step * width, x + first * dx, spacing * dx, 1, width, count, keep)


@njit(cache=True, nogil=True, error_model="numpy")
def _hit(x: float, y: float, angle: float, reach: float, height: int, width: int) -> int:
    """Return the index of the cell that a beam ended in, or −1 outside the window or where it did not end."""
    if not 0.0 < reach < np.inf:
        return -1
    column = math.floor(x + (reach + _INSIDE) * math.cos(angle))
    row = math.floor(y + (reach + _INSIDE) * math.sin(angle))
    return row * width + column if 0 <= row < height and 0 <= column < width else -1


@njit(
    types.void(_CELLS, _FLOAT, _FLOAT, _NUMBERS, _NUMBERS, _FLOAT, _FLOAT), cache=True, nogil=True, error_model="numpy"
)
def mark_and_clear(
    cells: NDArray[np.uint8],
    x: float,
    y: float,
    angles: NDArray[np.float64],
    ranges: NDArray[np.float64],
    obstacle_range: float,
    raytrace_range: float,
) -> None:
    """Clear what the beams went through, then mark what they ended in; all lengths in cells.

    Parameters
    ----------
    cells : (height, width) uint8 array
        Written to: free where a beam went through, lethal where one ended.
    x, y : float
        Of the laser.
    angles, ranges : (n,) float64 arrays
        From the x axis of the grid [rad]. Infinite: nothing was hit, and it clears. Not a number: no reading.
    obstacle_range, raytrace_range : float
        Longest range that marks, and up to which a beam clears.
    """
    height, width = cells.shape
    for i in range(angles.size):
        if ranges[i] > 0.0:
            keep = _hit(x, y, angles[i], ranges[i], height, width)
            far = min(ranges[i], raytrace_range)
            _clear(cells, x, y, math.cos(angles[i]), math.sin(angles[i]), far, keep)
    for i in range(angles.size):
        if 0.0 < ranges[i] <= obstacle_range:
            hit = _hit(x, y, angles[i], ranges[i], height, width)
            if hit >= 0:
                cells[hit // width, hit % width] = LETHAL_OBSTACLE


def warm() -> None:
    """Call each kernel once."""
    cells = np.zeros((4, 4), np.uint8)
    mark_and_clear(cells, 0.5, 0.5, np.array([0.0, 1.0]), np.array([1.0, np.inf]), 2.0, 3.0)
