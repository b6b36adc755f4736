"""Kernel: lay out the table of a tile: which of its cells are free, and what they cost."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION
from ppaas.planners.field.kernels.tile_layout import (
    ALL,
    BLOCKED,
    CELLS,
    COLUMNS,
    COST,
    FREE,
    KIND,
    LAID,
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
from ppaas.planners.kernels.addresses import map_of, numbers_of, octets_of
from ppaas.planners.kernels.jit_decorators import bare

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]
Tables = NDArray[np.uint32]


@bare
def _describe(cells: Bytes, at: Int, stride: Int, unknown: Int, tables: Tables, table: Int) -> Int:
    """Fill one table from 32 rows of costs that begin at ``at`` and lie ``stride`` apart; return the tile's kind."""
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
def _keep_part(source: Bytes, at: Int, width: Int, rows: Int, columns: Int, costs: Bytes, kept: Int) -> None:
    """Keep the costs of a tile that is not all on the map, filled up with blocked cells."""
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
def lay_tile(
    source: Bytes, height: Int, width: Int, unknown: Int, across: Int, tile: Int, costs: Bytes, tables: Tables
) -> None:
    """Fill the table of one tile.

    Parameters
    ----------
    source : (height · width,) uint8 array
        Costs of the map.
    height, width : int
        Of the map.
    unknown : lanes
        `ALL` if unknown cells are free, else 0.
    across : int
        Tiles side by side.
    tile : int
        Which.
    costs : (tiles · CELLS,) uint8 array
        Out: its costs, if they differ.
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
    _keep_part(source, top * width + left, width, rows, columns, costs, kept)
    _describe(costs, kept, np.int64(SIDE), unknown, tables, table)


@bare
def lay_sample(record: Ints, step: int) -> tuple[int, int]:
    """Fill the table of each ``step``-th tile.

    Parameters
    ----------
    record : (RECORD,) int64 array
        As in `ppaas.planners.field.kernels.tile_record`.
    step : int

    Returns
    -------
    free : int
        How many cells of theirs are free.
    forks : int
        How many of those have free ones on three of their four sides, or on all, within the tile.
    """
    source, height, width, unknown = map_of(record, SOURCE), record[HEIGHT], record[WIDTH], record[UNKNOWN]
    across, tiles = record[ACROSS], record[TILES]
    costs, tables, marks = octets_of(record, COSTS), numbers_of(record, TABLES), octets_of(record, MARKS)
    free, forks = 0, 0
    for tile in range(0, tiles, step):
        if not marks[tile] & LAID:
            lay_tile(source, height, width, unknown, across, tile, costs, tables)
            marks[tile] |= LAID
        above, cells, below = np.int64(0), np.int64(0), np.int64(tables[tile * TABLE + FREE])
        for row in range(SIDE):
            above, cells = cells, below
            below = np.int64(tables[tile * TABLE + FREE + row + 1] if row + 1 < SIDE else 0)
            left, right = cells << 1, cells >> 1
            free += simd.size(cells)
            forks += simd.size(cells & ((above & below & (left | right)) | (left & right & (above | below))))
    return free, forks


def warm() -> None:
    """Compile and call the kernel once that Python calls."""
    lay_sample(np.zeros(RECORD, np.int64), 1)
