"""Kernel: flood fill over the four neighbours of a cell."""

import numpy as np
from numba import types
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled


@compiled(
    types.uint8[:, ::1](types.Array(types.uint8, 2, "C", readonly=True), types.int64, types.int64),
)
def flood(free: NDArray[np.uint8], row: int, column: int) -> NDArray[np.uint8]:
    """Return the 4-connected component of free cells that contains a cell.

    Parameters
    ----------
    free : (height, width) uint8 array
        Not 0 in free cells.
    row, column : int
        First cell, within the grid.

    Returns
    -------
    (height, width) uint8 array
        1 in the component, else 0; all 0 if the first cell is not free.
    """
    height, width = free.shape
    found = np.zeros((height, width), np.uint8)
    if not free[row, column]:
        return found
    stack = np.empty(height * width, np.int64)  # indices of found cells to expand; each cell is pushed at most once
    stack[0] = row * width + column
    found[row, column] = 1
    size = 1
    while size:
        size -= 1
        r, c = divmod(stack[size], width)
        for dr, dc in ((-1, 0), (1, 0), (0, -1), (0, 1)):
            near_r, near_c = r + dr, c + dc
            if 0 <= near_r < height and 0 <= near_c < width and free[near_r, near_c] and not found[near_r, near_c]:
                found[near_r, near_c] = 1
                stack[size] = near_r * width + near_c
                size += 1
    return found


def warm() -> None:
    """Call each kernel once."""
    flood(np.ones((2, 2), np.uint8), 0, 0)
