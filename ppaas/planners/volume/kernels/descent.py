"""Kernel: descend a cost field in space, along exact equality of values."""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.planners.volume.kernels.layout import AT_GOAL, BLOCKED, DOWN, KINDS, NEEDS, RIGHT, UP


@compiled
def descend(
    field: NDArray[np.uint32], costs: NDArray[np.uint8], stride: int, plane: int, weights: NDArray[np.int64],
    cells: NDArray[np.int32], count: int, budget: int,
) -> int:  # fmt: skip
    """Extend a path by up to ``budget`` voxels; return its new length.

    Each step goes to a neighbour n with value(n) + weight of the move = value(voxel). It keeps the direction of the
    last step if possible, which selects one of the cheapest paths with few turns.

    Parameters
    ----------
    field, costs, stride, plane, weights
        As in `ppaas.planners.volume.kernels.propagation`; the value of the last voxel of the path must be final.
    cells : (m, 3) int32 array
        Layer, row, column on the map. Rows up to ``count``, at least one, are filled. In and out.
    count : int
        Length of the path so far.
    budget : int
        Maximum number of voxels to add.
    """
    ahead = -1
    if count > 1:
        for move in range(26):
            if (
                UP[move] == cells[count - 1, 0] - cells[count - 2, 0]
                and DOWN[move] == cells[count - 1, 1] - cells[count - 2, 1]
                and RIGHT[move] == cells[count - 1, 2] - cells[count - 2, 2]
            ):
                ahead = move
    for _ in range(budget):
        layer, row, column = cells[count - 1]
        here = (np.int64(layer) + 1) * plane + (np.int64(row) + 1) * stride + column + 1
        value = np.int64(field[here])
        if value == AT_GOAL:
            break
        found, open_moves = -1, 0
        for move in range(26):
            below = np.int64(field[here + UP[move] * plane + DOWN[move] * stride + RIGHT[move]])
            if open_moves & NEEDS[move] != NEEDS[move] or below == BLOCKED:
                continue
            open_moves |= 1 << move
            if (found < 0 or move == ahead) and below + weights[KINDS[move], costs[here]] == value:
                found = move
        if found < 0:
            break
        ahead = found
        cells[count, 0] = layer + UP[found]
        cells[count, 1] = row + DOWN[found]
        cells[count, 2] = column + RIGHT[found]
        count += 1
    return count


def warm() -> None:
    """Compile and call the kernel once."""
    field = np.zeros(27, np.uint32)
    field[13] = AT_GOAL
    weights, cells = np.ones((3, 256), np.int64), np.zeros((1, 3), np.int32)
    descend(field, np.zeros(27, np.uint8), 3, 9, weights, cells, 1, 1)
