"""Which cells a ray enters, and where: the geometry that ray casting and ray clearing share.

Lengths are in cells: cell (row, column) is the square [column, column + 1) × [row, row + 1). A ray enters a cell either
across a vertical line or across a horizontal one. So the cells of Amanatides and Woo's traversal ("A Fast Voxel
Traversal Algorithm for Ray Tracing", 1987) are had from two loops whose steps do not wait for each other: one over the
vertical lines that the ray crosses, one over the horizontal ones.

numba's cache of a kernel looks at the kernel's own file alone: after a change here, remove the ``*.nbi`` files.
"""

import math

import numpy as np
from numba import njit

PARALLEL = 1e-12
"""A direction less than this along an axis crosses none of its lines."""

FRACTION = 32
"""Bits behind the point of a fixed-point position: 2⁻³³ cells of error a step, and room for 2³⁰ cells."""

_LARGEST = 2.0**30


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def to_fixed(cells: float) -> int:
    """Return a position or a step in fixed point; one as long as no grid is cut to what fits."""
    return math.floor(min(max(cells, -_LARGEST), _LARGEST) * 2.0**FRACTION + 0.5)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def ahead(position: float, direction: float) -> int:
    """Return a position in fixed point, a millionth of a cell further on the way of the ray.

    So where a ray goes through a corner both loops see the cell beyond it. Rounding could else make each of them
    believe that the other line is crossed first, and that cell would be missed.
    """
    hair = 1 << (FRACTION - 20)
    return to_fixed(position) + (hair if direction > 0.0 else -hair if direction < 0.0 else 0)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def clip_axis(position: float, direction: float, size: int, near: float, far: float) -> tuple[float, float]:
    """Return the part of [near, far] in which a ray is between 0 and ``size`` along one axis; empty is near > far."""
    if abs(direction) < PARALLEL:
        if position < 0.0 or position >= size:
            return np.inf, -np.inf
        return near, far
    first = -position / direction
    second = (size - position) / direction
    return max(near, min(first, second)), min(far, max(first, second))


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def cell_at(position: float, size: int) -> int:
    """Return the cell of a position on one axis; one that rounding put just outside is brought back."""
    return min(max(math.floor(position), 0), size - 1)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def crossings(position: float, direction: float, cell: int, size: int, far: float) -> tuple[int, float, float]:
    """Return how many lines of one axis a ray crosses from ``cell`` on.

    Returns
    -------
    count : int
        Lines up to the length ``far`` or the edge of the grid.
    first : float
        Length of the ray at the first of them.
    spacing : float
        Length between two.
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
