"""Kernel: fill the table of a tile: which of its cells are free, and their costs."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION
from ppaas.kernel_cache.decorators import bare
from ppaas.planners.field.kernels.tile_layout import (
    ALL,
    BLOCKED,
    CELLS,
    COLUMNS,
    COST,
    FILLED,
    FREE,
    KIND,
    LETHAL,
    MIXED,
    OPEN,
    SIDE,
    TABLE,
    WALLED,
)  # fmt: skip
from ppaas.planners.field.kernels.tile_record import (
    ACROSS,
    COSTS,
    HEIGHT,
    MARKS,
    RECORD,
    SOURCE,
    TABLES,
    TILES,
    UNKNOWN,
    WIDTH,
)
from ppaas.planners.kernels import simd
from ppaas.planners.kernels.addresses import bytes_of, readonly_bytes_of, uint32s_of

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]
Tables = NDArray[np.uint32]


@bare
def _describe(cells: Bytes, at: Int, stride: Int, unknown: Int, tables: Tables, table: Int) -> Int:
    """Fill one table from 32 rows of costs that begin at ``at``, ``stride`` elements apart; return the tile's kind."""
    some, every, mixed, left, right = 0, ALL, 0, 0, 0
    cost: Int = -1
    for row in range(SIDE):
        begin = at + row * stride
        free = simd.bytes_below(cells, begin, INSCRIBED_INFLATED_OBSTACLE)
        free |= (ALL ^ simd.bytes_unlike(cells, begin, NO_INFORMATION)) & unknown
        if cost < 0 and free != 0:
            cost = np.int64(cells[begin + simd.first_lane(free)])
        mixed |= simd.bytes_unlike(cells, begin, cost) & free
        some |= free
        every &= free
        left |= (free & 1) << row
        right |= (free >> (SIDE - 1)) << row
        simd.put(tables, table + FREE + row, free)
    simd.put(tables, table + COLUMNS, left)
    simd.put(tables, table + COLUMNS + 1, right)
    kind = MIXED if mixed else OPEN if every == ALL else WALLED if some else BLOCKED
    tables[table + KIND] = kind
    tables[table + COST] = max(cost, 0)
    return np.int64(kind)


@bare
def _copy_partial(source: Bytes, at: Int, width: Int, rows: Int, columns: Int, costs: Bytes, kept: Int) -> None:
    """Copy the costs of a tile that is partly off the map, padded with blocked cells."""
    blocked = simd.splat(np.int64(LETHAL))
    for row in range(SIDE):
        begin, to = at + row * width, kept + row * SIDE
        if row >= rows:
            simd.store_bytes(costs, to, blocked)
        elif begin + SIDE <= len(source):
            simd.store_bytes(costs, to, simd.where((1 << columns) - 1, simd.load_bytes(source, begin), blocked))
        else:
            for column in range(SIDE):
                costs[to + column] = source[begin + column] if column < columns else LETHAL


@bare
def fill_tile(
    source: Bytes, height: Int, width: Int, unknown: Int, across: Int, tile: Int, costs: Bytes, tables: Tables
) -> None:
    """Fill the table of one tile.

    Parameters
    ----------
    source : (height · width,) uint8 array
        Costs of the map.
    height, width : int
        Size of the map.
    unknown : lanes
        `ALL` if unknown cells are free, else 0.
    across : int
        Number of tiles in a row.
    tile : int
        Number of the tile.
    costs : (tiles · CELLS,) uint8 array
        Out: costs of the tile, if its free cells have several, or it is partly off the map.
    tables : ((tiles + 1) · TABLE,) uint32 array
        Out: as in `ppaas.planners.field.kernels.tile_layout`.
    """
    top, left = tile // across * SIDE, tile % across * SIDE
    rows, columns = min(SIDE, height - top), min(SIDE, width - left)
    kept, table = tile * CELLS, tile * TABLE
    if rows == SIDE and columns == SIDE:
        kind = _describe(source, top * width + left, width, unknown, tables, table)
        for row in range(SIDE if kind == MIXED else 0):
            simd.store_bytes(costs, kept + row * SIDE, simd.load_bytes(source, (top + row) * width + left))
        return
    _copy_partial(source, top * width + left, width, rows, columns, costs, kept)
    _describe(costs, kept, np.int64(SIDE), unknown, tables, table)


@bare
def fill_sample(record: Ints, step: int) -> tuple[int, int]:
    """Fill the table of every ``step``-th tile, and count free cells and forks.

    Parameters
    ----------
    record : (RECORD,) int64 array
        As in `ppaas.planners.field.kernels.tile_record`.
    step : int

    Returns
    -------
    free : int
        Number of free cells of these tiles.
    forks : int
        Number of free cells with at least three free cardinal neighbours within the tile.
    """
    source, height, width, unknown = readonly_bytes_of(record, SOURCE), record[HEIGHT], record[WIDTH], record[UNKNOWN]
    across, tiles = record[ACROSS], record[TILES]
    costs, tables, marks = bytes_of(record, COSTS), uint32s_of(record, TABLES), bytes_of(record, MARKS)
    free, forks = 0, 0
    for tile in range(0, tiles, step):
        if not marks[tile] & FILLED:
            fill_tile(source, height, width, unknown, across, tile, costs, tables)
            marks[tile] |= FILLED
        above, cells, below = np.int64(0), np.int64(0), np.int64(tables[tile * TABLE + FREE])
        for row in range(SIDE):
            above, cells = cells, below
            below = np.int64(tables[tile * TABLE + FREE + row + 1] if row + 1 < SIDE else 0)
            left, right = cells << 1, cells >> 1
            free += simd.size(cells)
            forks += simd.size(cells & ((above & below & (left | right)) | (left & right & (above | below))))
    return free, forks


def warm() -> None:
    """Compile and call the kernel that Python calls."""
    fill_sample(np.zeros(RECORD, np.int64), 1)
