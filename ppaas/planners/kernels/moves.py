"""Kernels: the eight moves from a cell, and the reasons for which a search stops."""

from typing import Any

import numpy as np

from ppaas.kernel_cache.decorators import compiled

Int = int | np.signedinteger[Any]

EXHAUSTED = 0
"""The queue is empty: all reachable cells are settled."""
SETTLED = 1
"""The value of the target is final."""
PAUSED = 2
"""The budget is used up: call again."""
POOL_EMPTY = 3
"""The pool is full: enlarge it and call again."""

NEEDS = (0, 0, 0, 0, 1 | 4, 2 | 4, 1 | 8, 2 | 8)
"""For each move, the bits of the cardinal moves whose cells must be free. The order of moves is left, right, down, up,
then the diagonals."""


@compiled
def octile(cell: Int, target: Int, stride: Int, cardinal: Int, diagonal: Int) -> int:
    """Return the octile distance of two cells, with the weights of a cardinal and of a diagonal move."""
    # 32-bit unsigned division is the fastest.
    row, target_row = np.int64(np.uint32(cell) // np.uint32(stride)), np.int64(np.uint32(target) // np.uint32(stride))
    down = abs(row - target_row)
    right = abs((cell - row * stride) - (target - target_row * stride))
    return int(min(down, right) * diagonal + abs(down - right) * cardinal)
