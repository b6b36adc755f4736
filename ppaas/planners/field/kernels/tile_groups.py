"""Kernel parts: fill the tables of adjacent tiles together.

A single tile is 32 short pieces of memory far apart, each of which is a cache miss. A group of adjacent tiles is
therefore first scanned row by row across all its tiles, which is twice as fast. The scan detects uniform tiles, whose
rows do not differ from the first one. On many maps these are most tiles; they need no second scan.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION
from ppaas.kernel_cache.decorators import bare, joined
from ppaas.planners.field.kernels.tile_layout import ALL, BLOCKED, COLUMNS, COST, FILLED, FREE, KIND, OPEN, SIDE, TABLE
from ppaas.planners.field.kernels.tile_rows import CHANGES
from ppaas.planners.field.kernels.tile_setup import fill_tile
from ppaas.planners.kernels import atomics, simd
from ppaas.planners.kernels.prefetch import BYTES_PER_LINE, fetch_to_l2

FEW, MANY = 8, 32
"""Tiles in a group: `FEW` as long as the search may end soon, and on maps narrower than `MANY` tiles, where two threads
would fill the same group."""
EACH = 4
"""Tiles whose cells in one row of the map, a byte each, fill one row of `ppaas.planners.kernels.simd`."""

AHEAD = 4
"""Prefetch distance [rows]."""

Int = int | np.signedinteger[Any]
Bytes = NDArray[np.uint8]
Numbers = NDArray[np.uint32]


@bare
def _scan(source: Bytes, at: Int, width: Int, rows: Int, scratch: Numbers) -> None:
    """Collect, per column of adjacent tiles, the bits in which any cell differs from that in the tile's first row.

    There are ``rows`` · `EACH` tiles; the first one begins at ``at``. The result is in `CHANGES` of scratch memory.
    """
    for place in range(rows):
        simd.store(scratch, CHANGES + place * SIDE, simd.splat(np.int64(0)))
    for row in range(1, SIDE):
        for place in range(rows):
            first, changes = at + place * EACH * SIDE, CHANGES + place * SIDE
            for line in range(0, EACH * SIDE, BYTES_PER_LINE):
                fetch_to_l2(source, first + (row + AHEAD) * width + line)
            differing = simd.differing(
                simd.load_packed_bytes(source, first), simd.load_packed_bytes(source, first + row * width)
            )
            simd.store(scratch, changes, simd.either(simd.load(scratch, changes), differing))


@joined
def _is_uniform(source: Bytes, at: Int, place: Int, scratch: Numbers) -> bool:
    """Return whether all cells of a tile have one cost; it begins at ``at`` and is number ``place`` of its group."""
    changed = simd.unlike(simd.load(scratch, CHANGES + place // EACH * SIDE), simd.splat(np.int64(0)))
    if changed >> (place % EACH * (SIDE // EACH)) & ((1 << SIDE // EACH) - 1):
        return False
    return bool(simd.bytes_unlike(source, at, np.int64(source[at])) == 0)


@joined
def _fill_uniform(tables: Numbers, tile: Int, cost: Int, unknown: Int) -> None:
    """Fill the table of a tile whose cells all have one cost."""
    is_free = cost < INSCRIBED_INFLATED_OBSTACLE or (cost == NO_INFORMATION and unknown != 0)
    free, table = ALL if is_free else 0, tile * TABLE
    simd.store(tables, table + FREE, simd.splat(np.int64(free)))
    simd.put(tables, table + COLUMNS, np.int64(free))
    simd.put(tables, table + COLUMNS + 1, np.int64(free))
    tables[table + KIND] = OPEN if is_free else BLOCKED
    tables[table + COST] = cost if is_free else 0


@bare
def _fill_group(
    source: Bytes, height: Int, width: Int, unknown: Int, across: Int, begin: Int, end: Int,
    costs: Bytes, tables: Numbers, marks: Bytes, scratch: Numbers,
) -> None:  # fmt: skip
    """Fill the tables of adjacent tiles that are not filled yet.

    The marks are set after all tables are filled: each is an atomic step, which waits for earlier writes.
    """
    at = begin // across * SIDE * width + begin % across * SIDE
    whole = min(end - begin, (width - begin % across * SIDE) // SIDE)
    rows = whole // EACH if begin // across * SIDE + SIDE <= height else 0
    _scan(source, at, width, rows, scratch)
    for tile in range(begin, end):
        if atomics.read(marks, tile) & FILLED:
            continue
        place = tile - begin
        first = at + place * SIDE
        if place < rows * EACH and _is_uniform(source, first, place, scratch):
            _fill_uniform(tables, tile, np.int64(source[first]), unknown)
        else:
            fill_tile(source, height, width, unknown, across, tile, costs, tables)
    for tile in range(begin, end):
        if not atomics.read(marks, tile) & FILLED:  # filled just now
            atomics.mark(marks, tile, FILLED)


@bare
def fill_around(
    source: Bytes, height: Int, width: Int, unknown: Int, across: Int, tiles: Int, tile: Int,
    costs: Bytes, tables: Numbers, marks: Bytes, scratch: Numbers, is_far: bool,
) -> None:  # fmt: skip
    """Fill the tables of a tile, its neighbours and their groups, unless they are filled already.

    Two threads that fill the same table at once write the same data. Groups are large if ``is_far``: the search is not
    expected to end soon.
    """
    together = MANY if is_far and across >= MANY else FEW
    left, right = max(tile % across - 1, 0), min(tile % across + 1, across - 1)
    for row in range(max(tile // across - 1, 0), min(tile // across + 2, tiles // across)):
        before = row * across
        for column in range(left, right + 1):
            if not atomics.read(marks, before + column) & FILLED:
                begin = column // together * together
                end = min(begin + together, across)
                _fill_group(
                    source, height, width, unknown, across, before + begin, before + end, costs, tables, marks, scratch
                )
