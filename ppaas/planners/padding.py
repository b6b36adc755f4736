"""Padded costs, weights and neighbour offsets for kernels that read a map cell by cell."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import LETHAL_OBSTACLE
from ppaas.planners.weights import fixed_weights, passable

SLICE_BYTES = 1 << 20
"""Cells copied between two checks: about 1 ms if the memory is newly allocated."""


def padded(data: NDArray[np.uint8], check: Callable[[], None]) -> NDArray[np.uint8]:
    """Return (height + 2, width + 2) costs with a blocked cell on each side (see `field.kernels.layout`)."""
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
    """Return the (2, 256) weights of cardinal and diagonal moves in fixed point; 0 for blocked costs."""
    return np.where(passable(allow_unknown), fixed_weights(), 0)


def neighbour_offsets(stride: int) -> NDArray[np.int64]:
    """Return the (8,) index offsets of the neighbours of a cell: left, right, down, up, then the diagonals."""
    return np.array((-1, 1, -stride, stride, -stride - 1, -stride + 1, stride - 1, stride + 1))
