"""Kernel parts: lay out the tables of tiles that lie side by side together.

A tile alone is 32 short pieces of memory far apart, each of which is waited for. So the cells of a group of tiles are
first looked at row by row, all tiles of it in turn, which memory brings twice as fast. That look tells where nothing
differs from the first row, so that a tile all of one cost, as most are on many maps, need not be looked at again.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION
from ppaas.planners.field.kernels.tile_layout import ALL, BLOCKED, COLUMNS, COST, FREE, KIND, LAID, OPEN, SIDE, TABLE
from ppaas.planners.field.kernels.tile_rows import CHANGES
from ppaas.planners.field.kernels.tile_setup import lay_tile
from ppaas.planners.kernels import atomics, simd
from ppaas.planners.kernels.jit_decorators import bare, joined
from ppaas.planners.kernels.prefetch import OCTETS_A_LINE, fetch_close

FEW, MANY = 8, 32
"""So many tiles side by side make a group: few as long as the search may end soon, and where two threads would lay out
the same as groups are as wide as the map."""
EACH = 4
"""Tiles whose cells in a row of the map, an octet each, are one row of `ppaas.planners.kernels.simd`."""

AHEAD = 4
"""So many rows before they are looked at, cells are fetched."""

Int = int | np.signedinteger[Any]
Bytes = NDArray[np.uint8]
Numbers = NDArray[np.uint32]


@bare
def _look_down(source: Bytes, at: Int, width: Int, rows: Int, scratch: Numbers) -> None:
    """Gather in which bits the cells of tiles side by side differ from those above them in the first row.

    There are ``rows`` times `EACH` tiles, the first of which begins at ``at``.
    """
    for place in range(rows):
        simd.store(scratch, CHANGES + place * SIDE, simd.splat(np.int64(0)))
    for row in range(1, SIDE):
        for place in range(rows):
            first, changes = at + place * EACH * SIDE, CHANGES + place * SIDE
            for line in range(0, EACH * SIDE, OCTETS_A_LINE):
                fetch_close(source, first + (row + AHEAD) * width + line)
            differing = simd.differing(simd.load_octets(source, first), simd.load_octets(source, first + row * width))
            simd.store(scratch, changes, simd.either(simd.load(scratch, changes), differing))


@joined
def _is_alike(source: Bytes, at: Int, place: Int, scratch: Numbers) -> bool:
    """Return whether all cells cost the same of a tile that begins at ``at``, and is in that place of its group."""
    changed = simd.unlike(simd.load(scratch, CHANGES + place // EACH * SIDE), simd.splat(np.int64(0)))
    if changed >> (place % EACH * (SIDE // EACH)) & ((1 << SIDE // EACH) - 1):
        return False
    return bool(simd.bytes_unlike(source, at, np.int64(source[at])) == 0)


@joined
def _lay_alike(tables: Numbers, tile: Int, cost: Int, unknown: Int) -> None:
    """Fill the table of a tile whose cells all cost the same."""
    is_free = cost < INSCRIBED_INFLATED_OBSTACLE or (cost == NO_INFORMATION and unknown != 0)
    free, table = ALL if is_free else 0, tile * TABLE
    simd.store(tables, table + FREE, simd.splat(np.int64(free)))
    simd.put(tables, table + COLUMNS, np.int64(free))
    simd.put(tables, table + COLUMNS + 1, np.int64(free))
    tables[table + KIND] = OPEN if is_free else BLOCKED
    tables[table + COST] = cost if is_free else 0


@bare
def _lay_group(
    source: Bytes, height: Int, width: Int, unknown: Int, across: Int, begin: Int, end: Int,
    costs: Bytes, tables: Numbers, marks: Bytes, scratch: Numbers,
) -> None:  # fmt: skip
    """Fill the tables of tiles side by side, as far as nobody has.

    Marks are set after all are filled, as each waits for what was written before it.
    """
    at = begin // across * SIDE * width + begin % across * SIDE
    whole = min(end - begin, (width - begin % across * SIDE) // SIDE)
    rows = whole // EACH if begin // across * SIDE + SIDE <= height else 0
    _look_down(source, at, width, rows, scratch)
    for tile in range(begin, end):
        if atomics.read(marks, tile) & LAID:
            continue
        place = tile - begin
        first = at + place * SIDE
        if place < rows * EACH and _is_alike(source, first, place, scratch):
            _lay_alike(tables, tile, np.int64(source[first]), unknown)
        else:
            lay_tile(source, height, width, unknown, across, tile, costs, tables)
    for tile in range(begin, end):
        if not atomics.read(marks, tile) & LAID:  # so it was laid out just now
            atomics.mark(marks, tile, LAID)


@bare
def lay_around(
    source: Bytes, height: Int, width: Int, unknown: Int, across: Int, tiles: Int, tile: Int,
    costs: Bytes, tables: Numbers, marks: Bytes, scratch: Numbers, is_far: bool,
) -> None:  # fmt: skip
    """Fill the tables of a tile and of those around, and of the groups they are in, as far as nobody has.

    Two threads that come at a time both write the same. Groups are large if the search ``is_far`` from its end.
    """
    together = MANY if is_far and across >= MANY else FEW
    left, right = max(tile % across - 1, 0), min(tile % across + 1, across - 1)
    for row in range(max(tile // across - 1, 0), min(tile // across + 2, tiles // across)):
        before = row * across
        for column in range(left, right + 1):
            if not atomics.read(marks, before + column) & LAID:
                begin = column // together * together
                end = min(begin + together, across)
                _lay_group(
                    source, height, width, unknown, across, before + begin, before + end, costs, tables, marks, scratch
                )
