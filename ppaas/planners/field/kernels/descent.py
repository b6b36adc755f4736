"""Kernel: descend a cost field, along exact equality of values."""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.planners.field.kernels.layout import AT_GOAL, BLOCKED

Ints = NDArray[np.int64]
Field = NDArray[np.uint32] | NDArray[np.int64]


@compiled
def descend(
    field: Field, costs: NDArray[np.uint8], stride: int, weights: Ints,
    cells: NDArray[np.int32], count: int, budget: int,
) -> int:  # fmt: skip
    """Extend a path by up to ``budget`` cells; return its new length.

    Each step goes to a neighbour n with value(n) + weight of the move = value(cell). It keeps the direction of the last
    step if possible, which selects one of the cheapest paths with few turns. In a field with final values there is
    always such a neighbour.

    Parameters
    ----------
    field, costs, stride, weights
        As in `ppaas.planners.field.kernels.propagation`; the value of the last cell of the path must be final.
    cells : (m, 2) int32 array
        Row, column on the map. Rows up to ``count``, at least one, are filled. In and out.
    count : int
        Length of the path so far.
    budget : int
        Maximum number of cells to add.
    """
    rows = np.array([0, 1, 0, -1, 1, 1, -1, -1])
    columns = np.array([1, 0, -1, 0, 1, -1, -1, 1])
    row, column = np.int64(cells[count - 1, 0]), np.int64(cells[count - 1, 1])
    ahead = 0
    if count > 1:
        for move in range(8):
            if rows[move] == row - cells[count - 2, 0] and columns[move] == column - cells[count - 2, 1]:
                ahead = move
    for _ in range(budget):
        here = (row + 1) * stride + column + 1
        value = np.int64(field[here])
        if value == AT_GOAL:
            break
        found = -1
        for attempt in range(9):
            move = ahead if attempt == 0 else attempt - 1
            right, down = columns[move], rows[move] * stride
            if move > 3 and (field[here + right] == BLOCKED or field[here + down] == BLOCKED):
                continue
            below = np.int64(field[here + down + right])
            if below != BLOCKED and below + weights[move >> 2, costs[here]] == value:
                found = move
                break
        if found < 0:
            break
        ahead = found
        row += rows[found]
        column += columns[found]
        cells[count, 0] = row
        cells[count, 1] = column
        count += 1
    return count


def warm() -> None:
    """Compile and call the kernel once, for 32-bit and 64-bit fields."""
    weights = np.ones((2, 256), np.int64)
    for field in (np.zeros(9, np.uint32), np.zeros(9, np.int64)):
        field[4] = AT_GOAL
        descend(field, np.zeros(9, np.uint8), 3, weights, np.zeros((1, 2), np.int32), 1, 1)
