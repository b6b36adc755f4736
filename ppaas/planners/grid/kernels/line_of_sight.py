"""Kernels: traversal of the cells on the straight line between the centres of two cells, in integers.

A line over ``down`` rows and ``right`` columns crosses its i-th vertical cell border at (2i − 1)/(2·right) of its
length, and its j-th horizontal one at (2j − 1)/(2·down). Multiplied by 2·down·right both are integers, so nothing is
rounded: a line is the same from either end, and it passes exactly through a corner where both are equal. There it makes
a diagonal move, which needs both cells beside it free, as everywhere on the grid.

Source of the traversal: Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", 1987.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

Int = int | np.signedinteger[Any]
Costs = NDArray[np.uint8]
Ints = NDArray[np.int64]

_1 = np.int64(1)

HIDDEN = -1.0
"""Result without a line of sight."""

HAIR = 1e-9
"""Relative tolerance: a cost counts as lower only by more than this, so that rounding does not cause endless
updates."""


@compiled
def weigh(costs: Costs, stride: Int, weights: Ints, cell: Int, down: Int, right: Int) -> float:
    """Return the integral of the weights along a line, or `HIDDEN` if it crosses a blocked cell.

    Parameters
    ----------
    costs : (n,) uint8 array
        Costs of the cells, padded with blocked ones as in `ppaas.planners.field.kernels.layout`.
    stride : int
        Number of elements in a row.
    weights : (256,) int64 array
        Weight per length of a cell of each cost; 0 is blocked.
    cell : int
        Begin of the line: an element of ``costs``.
    down, right : int
        Rows and columns from its begin to its end, which must be on the map.
    """
    rows, columns = abs(np.int64(down)), abs(np.int64(right))
    row_step = stride if down > 0 else -stride
    column_step = 1 if right > 0 else -1
    # Positions along the line in integer units: `tall` between two rows, `wide` between two columns, `end` in total.
    tall, wide = 2 * max(columns, _1), 2 * max(rows, _1)
    end = max(rows, _1) * max(columns, _1) * 2
    next_row = tall >> 1 if rows > 0 else end + 1
    next_column = wide >> 1 if columns > 0 else end + 1
    at = cell
    weight = weights[costs[at]]
    if weight == 0:
        return HIDDEN
    passed, total = np.int64(0), np.int64(0)
    for _ in range(rows + columns):
        if next_row == next_column:
            total += weight * (next_row - passed)
            passed = next_row
            if weights[costs[at + row_step]] == 0 or weights[costs[at + column_step]] == 0:
                return HIDDEN
            at += row_step + column_step
            next_row += tall
            next_column += wide
        elif next_row < next_column:
            total += weight * (next_row - passed)
            passed = next_row
            at += row_step
            next_row += tall
        else:
            total += weight * (next_column - passed)
            passed = next_column
            at += column_step
            next_column += wide
        weight = weights[costs[at]]
        if weight == 0:
            return HIDDEN
        if next_row > end and next_column > end:
            break
    total += weight * (end - passed)
    return float(total * (math.sqrt(rows * rows + columns * columns) / end))


@compiled
def trace(down: int, right: int, cells: NDArray[np.int32], points: NDArray[np.float64]) -> int:
    """Write the cells that a line enters, and its midpoint within each; return their number.

    Parameters
    ----------
    down, right : int
        Rows and columns from its begin to its end.
    cells : (≥ |down| + |right|, 2) int32 array
        Out: row, column relative to the first cell, which is not written; each a neighbour of the one before.
    points : (≥ |down| + |right|, 2) float64 array
        Out: row, column of the midpoints, relative to the first cell; for the last cell its centre.
    """
    rows, columns = abs(down), abs(right)
    row_step, column_step = (1 if down > 0 else -1), (1 if right > 0 else -1)
    tall, wide = 2 * max(columns, 1), 2 * max(rows, 1)
    end = max(rows, 1) * max(columns, 1) * 2
    next_row = tall >> 1 if rows > 0 else end + 1
    next_column = wide >> 1 if columns > 0 else end + 1
    row, column, count = 0, 0, 0
    while next_row <= end or next_column <= end:
        entered = min(next_row, next_column)
        if next_row == entered:
            row += row_step
            next_row += tall
        if next_column == entered:
            column += column_step
            next_column += wide
        part = (entered + min(next_row, next_column)) / (2 * end)
        cells[count, 0], cells[count, 1] = row, column
        points[count, 0], points[count, 1] = down * part, right * part
        count += 1
    if count > 0:
        points[count - 1, 0], points[count - 1, 1] = down, right
    return count


def warm() -> None:
    """Compile and call each kernel once."""
    weigh(np.zeros(9, np.uint8), 3, np.ones(256, np.int64), 4, 0, 0)
    trace(1, 1, np.zeros((2, 2), np.int32), np.zeros((2, 2)))
