"""Kernel: lay out the tables of the tiles of a map: which cells are free, and what they cost."""

from typing import Any

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from ppaas.planners.kernels import simd
from ppaas.planners.kernels.tile_layout import (
    ALL,
    BLOCKED,
    CELLS,
    COST,
    EDGES,
    FREE,
    KIND,
    LETHAL,
    MIXED,
    OPEN,
    SIDE,
    TABLE,
    UNREACHED,
    WALLED,
)  # fmt: skip

Int = int | np.signedinteger[Any]
Bytes = NDArray[np.uint8]
Tables = NDArray[np.uint32]


@njit(cache=True, nogil=True, error_model="numpy")
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
    _empty_edges(tables, table)
    kind = MIXED if mixed else OPEN if every == ALL else WALLED if some else BLOCKED
    tables[table + KIND] = kind
    tables[table + COST] = max(cost, 0)


@njit(cache=True, nogil=True, error_model="numpy")
def _lay_tile(
    source: Bytes, height: Int, width: Int, unknown: Int, across: Int, tile: Int, costs: Bytes, tables: Tables
) -> None:
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


@njit(cache=True, nogil=True, error_model="numpy", parallel=True)
def lay_tiles(
    source: Bytes, height: int, width: int, allow_unknown: bool, across: int, first: int, last: int,
    costs: Bytes, tables: Tables, threads: int,
) -> None:  # fmt: skip
    """Fill the tables of tiles ``first`` to ``last``.

    Parameters
    ----------
    source : (height · width,) uint8 array
        Costs of the map.
    height, width : int
        Of the map.
    allow_unknown : bool
        Whether unknown cells are free.
    across : int
        Tiles side by side.
    first, last : int
        Tiles to do, ``last`` excluded.
    costs : (tiles · CELLS,) uint8 array
        Out: the costs of tiles whose costs differ, tile by tile.
    tables : ((tiles + 1) · TABLE,) uint32 array
        Out: as in `ppaas.planners.kernels.tile_layout`.
    threads : int
        Threads to use; with one, no parallel region is entered.
    """
    unknown = ALL if allow_unknown else 0
    if threads == 1:
        for tile in range(first, last):
            _lay_tile(source, height, width, unknown, across, tile, costs, tables)
    else:
        for tile in prange(first, last):
            _lay_tile(source, height, width, unknown, across, tile, costs, tables)


@njit(cache=True, nogil=True, error_model="numpy")
def forget(tables: Tables, marks: NDArray[np.uint16], tiles: int) -> None:
    """Empty the edges of all tiles in which somebody has been, or that somebody would have bettered."""
    for tile in range(tiles):
        if marks[tile]:
            _empty_edges(tables, tile * TABLE)
            marks[tile] = 0


@njit(cache=True, nogil=True, error_model="numpy", forceinline=True)
def _empty_edges(tables: Tables, table: Int) -> None:
    for side in range(4):
        simd.store(tables, table + EDGES + side * SIDE, simd.splat(UNREACHED))


@njit(cache=True, nogil=True, error_model="numpy")
def count_wide(tables: Tables, tiles: int, step: int) -> tuple[int, int]:
    """Return of each ``step``-th tile how many cells are free, and how many have free ones right, below and between."""
    free, wide = 0, 0
    for tile in range(0, tiles, step):
        table = tile * TABLE + FREE
        below = np.int64(tables[table + SIDE - 1])
        for row in range(SIDE - 1, -1, -1):
            cells = np.int64(tables[table + row])
            pairs = cells & below
            free += simd.size(cells)
            wide += simd.size(pairs & (pairs >> 1))
            below = cells
    return free, wide


def warm() -> None:
    """Compile and call each kernel once."""
    source = np.zeros(1, np.uint8)
    source.flags.writeable = False
    lay_tiles(source, 1, 1, True, 1, 0, 1, np.zeros(CELLS, np.uint8), np.zeros(2 * TABLE, np.uint32), 1)
    forget(np.zeros(TABLE, np.uint32), np.ones(1, np.uint16), 1)
    count_wide(np.zeros(TABLE, np.uint32), 1, 1)
