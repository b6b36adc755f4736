"""Kernels: the eight moves from a cell, and why a search over them stopped."""

from typing import Any

import numpy as np
from numba import njit

Int = int | np.signedinteger[Any]

EXHAUSTED = 0
"""No cell is left to work off."""
SETTLED = 1
"""The value of the target is final."""
PAUSED = 2
"""The slice is used up: call again."""
POOL_EMPTY = 3
"""There is no room for more: enlarge the pool and call again."""

NEEDS = (0, 0, 0, 0, 1 | 4, 2 | 4, 1 | 8, 2 | 8)
"""For each move which of the first four must be open, one bit each: left, right, down, up, then the diagonals."""


@njit(cache=True, nogil=True, error_model="numpy")
def octile(cell: Int, target: Int, stride: Int, cardinal: Int, diagonal: Int) -> int:
    """Return the least that moves between two cells can weigh."""
    # Unsigned and short: the fastest division there is.
    row, target_row = np.int64(np.uint32(cell) // np.uint32(stride)), np.int64(np.uint32(target) // np.uint32(stride))
    down = abs(row - target_row)
    right = abs((cell - row * stride) - (target - target_row * stride))
    return int(min(down, right) * diagonal + abs(down - right) * cardinal)
