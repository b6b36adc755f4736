"""Kernels that read a tile field: descend it, count settled cells, copy it row by row."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.planners.field.kernels.tile_layout import CELLS, FREE, SIDE, TABLE, TOUCHED, UNREACHED
from ppaas.planners.kernels import simd

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]
Numbers = NDArray[np.uint32]
Marks = NDArray[np.uint8]


@compiled(forceinline=True)
def _value(field: Numbers, marks: Marks, across: Int, row: Int, column: Int) -> Int:
    tile = row // SIDE * across + column // SIDE
    if not marks[tile] & TOUCHED:
        return UNREACHED
    return np.int64(field[tile * CELLS + row % SIDE * SIDE + column % SIDE])


@compiled(forceinline=True)
def _is_free(tables: Numbers, across: Int, row: Int, column: Int) -> bool:
    tile = row // SIDE * across + column // SIDE
    return bool(np.int64(tables[tile * TABLE + FREE + row % SIDE]) >> column % SIDE & 1)


@compiled
def descend_tiles(
    field: Numbers, tables: Numbers, marks: Marks, source: NDArray[np.uint8], height: int, width: int, across: int,
    weights: Ints, cells: NDArray[np.int32], count: int, budget: int,
) -> int:  # fmt: skip
    """Extend a path by up to ``budget`` cells; return its new length.

    It selects the same path as `ppaas.planners.field.kernels.descent.descend`.

    Parameters
    ----------
    field, tables, marks, across
        As in `ppaas.planners.field.kernels.tile_record`; the value of the last cell of the path must be final.
    source : (height · width,) uint8 array
        Costs of the map.
    height, width : int
        Size of the map.
    weights : (2, 256) int64 array
        Weight of entering a cell of each cost, on a cardinal and on a diagonal move.
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
    value = _value(field, marks, across, row, column)
    ahead = 0
    if count > 1:
        for move in range(8):
            if rows[move] == row - cells[count - 2, 0] and columns[move] == column - cells[count - 2, 1]:
                ahead = move
    for _ in range(budget):
        if value == 0:
            break
        cost = source[row * width + column]
        found = -1
        for attempt in range(9):
            move = ahead if attempt == 0 else attempt - 1
            r, c = row + rows[move], column + columns[move]
            if r < 0 or c < 0 or r >= height or c >= width:
                continue
            if _value(field, marks, across, r, c) + weights[move >> 2, cost] != value:
                continue
            if move < 4 or (_is_free(tables, across, row, c) and _is_free(tables, across, r, column)):
                found = move
                break
        if found < 0:
            break
        ahead = found
        value -= weights[found >> 2, cost]
        row += rows[found]
        column += columns[found]
        cells[count, 0], cells[count, 1] = row, column
        count += 1
    return int(count)


@compiled
def count_up_to(field: Numbers, marks: Marks, first: int, last: int, most: int) -> int:
    """Return the number of cells of tiles ``first`` to ``last`` whose value is at most ``most``."""
    count: Int = 0
    above = simd.splat(most + 1)
    for tile in range(first, last):
        if marks[tile] & TOUCHED:
            for row in range(SIDE):
                count += simd.size(simd.less(simd.load(field, tile * CELLS + row * SIDE), above))
    return int(count)


@compiled
def read_rows(
    field: Numbers, marks: Marks, across: int, first: int, last: int, scale: float, values: NDArray[np.float64]
) -> None:
    """Write rows ``first`` to ``last`` of the field to ``values``, divided by ``scale``; infinite if not reached."""
    width = values.shape[1]
    for row in range(first, last):
        for left in range(0, width, SIDE):
            tile = row // SIDE * across + left // SIDE
            begin = tile * CELLS + row % SIDE * SIDE
            touched = marks[tile] & TOUCHED != 0
            for column in range(left, min(left + SIDE, width)):
                value = field[begin + column - left]
                values[row, column] = value / scale if touched and value < UNREACHED else np.inf


def warm() -> None:
    """Compile and call each kernel once."""
    field, tables, marks = np.zeros(CELLS, np.uint32), np.zeros(TABLE, np.uint32), np.full(1, TOUCHED, np.uint8)
    source, cells = np.zeros(1, np.uint8), np.zeros((1, 2), np.int32)
    source.flags.writeable = False
    descend_tiles(field, tables, marks, source, 1, 1, 1, np.ones((2, 256), np.int64), cells, 1, 1)
    count_up_to(field, marks, 0, 1, 0)
    read_rows(field, marks, 1, 0, 1, 1, np.zeros((1, 1)))
