"""Kernels: marking and clearing of cells by laser beams, as in costmap_2d's obstacle layer."""

import math

import numpy as np
from numba import types
from numpy.typing import NDArray

from ppaas.cost_values import FREE_SPACE, LETHAL_OBSTACLE
from ppaas.kernel_cache.decorators import compiled
from ppaas.maps.kernels.traversal import FRACTION, ahead, cell_at, clip_axis, crossings, to_fixed

_CELLS = types.uint8[:, ::1]
_NUMBERS = types.Array(types.float64, 1, "C", readonly=True)
_FLOAT = types.float64

_INSIDE = 0.02
"""Offset behind the end of a beam at which the hit cell is looked up, so that rounding does not select the cell before
it [cells]."""


@compiled
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
    """Free the cells behind a ray's crossings with the lines of one axis, except ``keep``.

    Parameters
    ----------
    flat : (height · width,) uint8 array
        Modified: the cells.
    index : int
        Index in ``flat`` of the cell behind the first crossing, at position 0 of the other axis.
    stride : int
        Difference of indices between two crossings.
    side : float
        Position on the other axis at the first crossing [cells].
    slope : float
        Difference of positions on the other axis between two crossings [cells].
    side_stride : int
        Difference of indices between two cells along the other axis.
    size : int
        Number of cells along the other axis.
    count : int
        Number of crossings.
    keep : int
        Index of the cell in which the beam ended; −1 for none.
    """
    position, move = ahead(side, slope), to_fixed(slope)
    for i in range(count):
        cell = position >> FRACTION
        entered = index + i * stride + cell * side_stride
        if 0 <= cell < size and entered != keep:
            flat[entered] = FREE_SPACE
        position += move


@compiled
def _clear(cells: NDArray[np.uint8], x: float, y: float, dx: float, dy: float, far: float, keep: int) -> None:
    """Free the cells that a ray from (x, y) in the unit direction (dx, dy) passes up to ``far``, except ``keep``."""
    height, width = cells.shape
    # Clip the ray to the window.
    near, end = clip_axis(x, dx, width, 0.0, far)
    near, end = clip_axis(y, dy, height, near, end)
    if near > end:
        return
    row, column = cell_at(y + near * dy, height), cell_at(x + near * dx, width)
    flat = cells.reshape(cells.size)
    if row * width + column != keep:
        cells[row, column] = FREE_SPACE
    # Cells behind crossings with vertical lines.
    count, first, spacing = crossings(x, dx, column, width, end)
    step = 1 if dx > 0.0 else -1
    _free(flat, column + step, step, y + first * dy, spacing * dy, width, height, count, keep)
    # Cells behind crossings with horizontal lines.
    count, first, spacing = crossings(y, dy, row, height, end)
    step = 1 if dy > 0.0 else -1
    _free(flat, (row + step) * width, step * width, x + first * dx, spacing * dx, 1, width, count, keep)


@compiled
def _hit(x: float, y: float, angle: float, reach: float, height: int, width: int) -> int:
    """Return the index of the cell in which a beam ended; −1 if it is outside the window or the beam hit nothing."""
    if not 0.0 < reach < np.inf:
        return -1
    column = math.floor(x + (reach + _INSIDE) * math.cos(angle))
    row = math.floor(y + (reach + _INSIDE) * math.sin(angle))
    return row * width + column if 0 <= row < height and 0 <= column < width else -1


@compiled(types.void(_CELLS, _FLOAT, _FLOAT, _NUMBERS, _NUMBERS, _FLOAT, _FLOAT))
def mark_and_clear(
    cells: NDArray[np.uint8],
    x: float,
    y: float,
    angles: NDArray[np.float64],
    ranges: NDArray[np.float64],
    obstacle_range: float,
    raytrace_range: float,
) -> None:
    """Free the cells that beams pass, then mark the cells in which they end; all lengths are in cells.

    Parameters
    ----------
    cells : (height, width) uint8 array
        Modified: ``FREE_SPACE`` in cells that a beam passes, ``LETHAL_OBSTACLE`` in cells in which one ends.
    x, y : float
        Position of the laser, from the corner of cell (0, 0).
    angles : (n,) float64 array
        Directions of the beams, from the x axis of the grid [rad].
    ranges : (n,) float64 array
        Ranges of the beams. Infinite: nothing was hit, the beam only clears. NaN: no reading.
    obstacle_range : float
        Longest range that marks a cell.
    raytrace_range : float
        Range up to which a beam clears cells.
    """
    height, width = cells.shape
    # Clear with all beams before marking, so that no beam erases the mark of another.
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
