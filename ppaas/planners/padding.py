"""Costs with a margin, and the moves on them: what kernels take that read the costs of a map cell by cell."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import LETHAL_OBSTACLE
from ppaas.planners.weights import fixed_weights, passable

SLICE_BYTES = 1 << 20
"""Cells copied between two checks: about 1 ms where the memory is new."""


def padded(data: NDArray[np.uint8], check: Callable[[], None]) -> NDArray[np.uint8]:
    """Return (height + 2, width + 2) costs with a blocked cell on each side, as `kernels.layout` has it."""
    height, width = data.shape
    costs = np.empty((height + 2, width + 2), np.uint8)
    costs[[0, -1]] = LETHAL_OBSTACLE
    costs[:, [0, -1]] = LETHAL_OBSTACLE
    rows = max(1, SLICE_BYTES // width)
    for first in range(0, height, rows):
        check()
        costs[first + 1 : min(first + rows, height) + 1, 1:-1] = data[first : first + rows]
    return costs


def blocking_weights(allow_unknown: bool) -> NDArray[np.int64]:
    """Return the (2, 256) weights of cardinal and diagonal moves in fixed point; 0 for cells that are blocked."""
    return np.where(passable(allow_unknown), fixed_weights(), 0)


def neighbour_offsets(stride: int) -> NDArray[np.int64]:
    """Return the (8,) distances from a cell to its neighbours: left, right, down, up, then the diagonals."""
    return np.array((-1, 1, -stride, stride, -stride - 1, -stride + 1, stride - 1, stride + 1))
