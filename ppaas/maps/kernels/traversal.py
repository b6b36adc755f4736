"""Kernels: grid traversal by rays, shared by ray casting and ray clearing.

Lengths are in cells; cell (row, column) is the square [column, column + 1) × [row, row + 1). A ray enters a cell across
either a vertical or a horizontal grid line. So the cells of Amanatides and Woo's traversal ("A Fast Voxel Traversal
Algorithm for Ray Tracing", 1987) result from two independent loops: one over the vertical lines that the ray crosses,
and one over the horizontal lines.
"""

import math

import numpy as np

from ppaas.kernel_cache.decorators import compiled

PARALLEL = 1e-12
"""Component of a direction below which a ray is parallel to an axis and crosses none of its lines."""

FRACTION = 32
"""Fractional bits of a fixed-point position: an error of 2⁻³³ cells per step, and a range of 2³⁰ cells."""

_LARGEST = 2.0**30
"""Largest magnitude of a fixed-point position [cells]."""


@compiled(inline="always")
def to_fixed(cells: float) -> int:
    """Return a position or a step [cells] in fixed point, limited to the range of fixed-point numbers."""
    return math.floor(min(max(cells, -_LARGEST), _LARGEST) * 2.0**FRACTION + 0.5)


@compiled(inline="always")
def ahead(position: float, direction: float) -> int:
    """Return a position in fixed point, moved by about a millionth of a cell in the direction of the ray.

    So if a ray passes through the corner of cells, both loops find the cell beyond the corner. Otherwise rounding could
    make each loop assume that the other line is crossed first, and the cell would be missed.
    """
    offset = 1 << (FRACTION - 20)
    return to_fixed(position) + (offset if direction > 0.0 else -offset if direction < 0.0 else 0)


@compiled(inline="always")
def clip_axis(position: float, direction: float, size: int, near: float, far: float) -> tuple[float, float]:
    """Clip the range [near, far] of a ray to positions between 0 and ``size`` on one axis; empty if near > far."""
    if abs(direction) < PARALLEL:
        if position < 0.0 or position >= size:
            return np.inf, -np.inf
        return near, far
    first = -position / direction
    second = (size - position) / direction
    return max(near, min(first, second)), min(far, max(first, second))


@compiled(inline="always")
def cell_at(position: float, size: int) -> int:
    """Return the cell at a position on one axis, limited to the grid because of rounding."""
    return min(max(math.floor(position), 0), size - 1)


@compiled(inline="always")
def crossings(position: float, direction: float, cell: int, size: int, far: float) -> tuple[int, float, float]:
    """Return the crossings of a ray with the grid lines of one axis.

    Parameters
    ----------
    position, direction : float
        Start [cells] and unit direction of the ray, on this axis.
    cell : int
        First cell of the ray within the grid.
    size : int
        Number of cells.
    far : float
        Longest range [cells].

    Returns
    -------
    count : int
        Number of lines crossed up to the range ``far`` or the last cell of the grid.
    first : float
        Range of the first crossing [cells].
    spacing : float
        Difference of ranges between two crossings [cells].
    """
    if abs(direction) < PARALLEL:
        return 0, np.inf, np.inf
    forward = direction > 0.0
    line = cell + 1 if forward else cell
    left = size - 1 - cell if forward else cell
    first = max((line - position) / direction, 0.0)
    spacing = 1.0 / abs(direction)
    if first > far:
        return 0, first, spacing
    return min(left, int((far - first) / spacing) + 1), first, spacing
