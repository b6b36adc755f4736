"""Kernel: lay out the tables of the tiles of a map: which cells are free, and what they cost."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.kernels import atomics, simd
from ppaas.planners.kernels.bare import bare
from ppaas.planners.kernels.tile_layout import (
    ALL,
    BLOCKED,
    CELLS,
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

Int = int | np.signedinteger[Any]
Bytes = NDArray[np.uint8]
Tables = NDArray[np.uint32]


@bare
def _describe(cells: Bytes, at: Int, stride: Int, unknown: Int, tables: Tables, table: Int) -> None:
    """Fill one table from 32 rows of costs that begin at ``at`` and lie ``stride`` apart."""
    columns = simd.splat(0)
    some, every, mixed = 0, ALL, 0
    cost: Int = -1
    for row in range(SIDE):
        costs = simd.load_bytes(cells, at + row * stride)
        free = simd.less(costs, simd.splat(253)) | (ALL ^ simd.unlike(costs, simd.splat(255))) & unknown
        if cost < 0 and free != 0:
            cost = np.int64(cells[at + row * stride + simd.first_lane(free)])
        mixed |= simd.unlike(costs, simd.splat(cost)) & free
        some |= free
        every &= free
        tables[table + FREE + row] = free
        columns = simd.either(columns, simd.where(free, simd.splat(1 << row), simd.splat(0)))
    simd.store(tables, table + FREE + SIDE, columns)
    kind = MIXED if mixed else OPEN if every == ALL else WALLED if some else BLOCKED
    tables[table + KIND] = kind
    tables[table + COST] = max(cost, 0)


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
        Out: as in `ppaas.planners.kernels.tile_layout`.
    """
    top, left = tile // across * SIDE, tile % across * SIDE
    rows, columns = min(SIDE, height - top), min(SIDE, width - left)
    kept, table = tile * CELLS, tile * TABLE
    if rows == SIDE and columns == SIDE:
        _describe(source, top * width + left, width, unknown, tables, table)
        for row in range(SIDE if tables[table + KIND] == MIXED else 0):
            simd.store_bytes(costs, kept + row * SIDE, simd.load_bytes(source, (top + row) * width + left))
        return
    for row in range(SIDE):
        for column in range(SIDE):
            inside = row < rows and column < columns
            costs[kept + row * SIDE + column] = source[(top + row) * width + left + column] if inside else LETHAL
    _describe(costs, kept, np.int64(SIDE), unknown, tables, table)


@bare
def lay_around(
    source: Bytes, height: Int, width: Int, unknown: Int, across: Int, tiles: Int, tile: Int,
    costs: Bytes, tables: Tables, marks: Bytes,
) -> None:  # fmt: skip
    """Fill the tables of a tile and of those around, as far as nobody has.

    Two threads that come at a time both write the same.
    """
    column = tile % across
    for row in range(tile // across - 1, tile // across + 2):
        for beside in range(row * across + max(column - 1, 0), row * across + min(column + 1, across - 1) + 1):
            if 0 <= beside < tiles and not atomics.read(marks, beside) & LAID:
                lay_tile(source, height, width, unknown, across, beside, costs, tables)
                atomics.mark(marks, beside, LAID)


@bare
def lay_sample(
    source: Bytes, height: int, width: int, unknown: int, across: int, tiles: int, step: int,
    costs: Bytes, tables: Tables, marks: Bytes,
) -> tuple[int, int]:  # fmt: skip
    """Fill the table of each ``step``-th tile.

    Returns
    -------
    free : int
        How many cells of theirs are free.
    wide : int
        How many of those have free ones right, below and between.
    """
    free, wide = 0, 0
    for tile in range(0, tiles, step):
        if not marks[tile] & LAID:
            lay_tile(source, height, width, unknown, across, tile, costs, tables)
            marks[tile] |= LAID
        below = np.int64(tables[tile * TABLE + FREE + SIDE - 1])
        for row in range(SIDE - 1, -1, -1):
            cells = np.int64(tables[tile * TABLE + FREE + row])
            pairs = cells & below
            free += simd.size(cells)
            wide += simd.size(pairs & (pairs >> 1))
            below = cells
    return free, wide


def warm() -> None:
    """Compile and call each kernel once."""
    source = np.zeros(1, np.uint8)
    source.flags.writeable = False
    tables, marks = np.zeros(2 * TABLE, np.uint32), np.zeros(1, np.uint8)
    lay_sample(source, 1, 1, ALL, 1, 1, 1, np.zeros(CELLS, np.uint8), tables, marks)
