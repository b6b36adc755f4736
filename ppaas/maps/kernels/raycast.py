"""Kernels: exact ray casting in a grid of occupied cells."""

import math

import numpy as np
from numba import types
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.maps.kernels.traversal import FRACTION, ahead, cell_at, clip_axis, crossings, to_fixed

_CELLS = types.Array(types.uint8, 2, "C", readonly=True)
_NUMBERS = types.Array(types.float64, 1, "C", readonly=True)


@compiled
def _first(
    flat: NDArray[np.uint8], index: int, stride: int, side: float, slope: float, side_stride: int, size: int, count: int
) -> int:
    """Return the first of a ray's crossings with the lines of one axis that leads into an occupied cell, or ``count``.

    Parameters
    ----------
    flat : (height · width,) uint8 array
        Not 0 in occupied cells.
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
    """
    # Fixed point: a shift is faster than rounding, and an addition faster than a multiplication.
    position, move = ahead(side, slope), to_fixed(slope)
    for i in range(count):
        cell = position >> FRACTION
        # The unsigned index spares numba's check for negative indices.
        if 0 <= cell < size and flat[np.uint64(index + cell * side_stride)]:
            return i
        position += move
        index += stride
    return count


@compiled
def _cast(occupied: NDArray[np.uint8], x: float, y: float, dx: float, dy: float, far: float) -> float:
    """Return the range of one ray from (x, y) in the unit direction (dx, dy) [cells], infinite without a hit."""
    height, width = occupied.shape
    # Clip the ray to the grid.
    near, end = clip_axis(x, dx, width, 0.0, far)
    near, end = clip_axis(y, dy, height, near, end)
    if near > end:
        return np.inf
    row, column = cell_at(y + near * dy, height), cell_at(x + near * dx, width)
    if occupied[row, column]:
        return near
    flat = occupied.ravel()
    hit = np.inf

    # Crossings with vertical lines.
    count, first, spacing = crossings(x, dx, column, width, end)
    step = 1 if dx > 0.0 else -1
    i = _first(flat, column + step, step, y + first * dy, spacing * dy, width, height, count)
    if i < count:
        hit = first + i * spacing

    # Crossings with horizontal lines, up to the hit so far.
    count, first, spacing = crossings(y, dy, row, height, min(end, hit))
    step = 1 if dy > 0.0 else -1
    i = _first(flat, (row + step) * width, step * width, x + first * dx, spacing * dx, 1, width, count)
    if i < count:
        hit = min(hit, first + i * spacing)
    return hit


@compiled(
    types.float64[::1](_CELLS, types.float64, types.float64, _NUMBERS, types.float64),
)
def cast_rays(
    occupied: NDArray[np.uint8], x: float, y: float, angles: NDArray[np.float64], far: float
) -> NDArray[np.float64]:
    """Return the distance at which each ray enters an occupied cell.

    Parameters
    ----------
    occupied : (height, width) uint8 array
        Not 0 in occupied cells.
    x, y : float
        Start of the rays [cells]; it may be outside the grid, where nothing stops a ray.
    angles : (n,) float64 array
        Directions of the rays, from the x axis of the grid [rad].
    far : float
        Longest range [cells].

    Returns
    -------
    (n,) float64 array
        Ranges [cells]; 0 if the rays start in an occupied cell, infinite if none was entered.
    """
    ranges = np.empty(angles.size)
    for i in range(angles.size):
        ranges[i] = _cast(occupied, x, y, math.cos(angles[i]), math.sin(angles[i]), far)
    return ranges


def warm() -> None:
    """Call each kernel once."""
    cast_rays(np.zeros((2, 2), np.uint8), 0.5, 0.5, np.array([0.0, 2.0]), 1.0)
