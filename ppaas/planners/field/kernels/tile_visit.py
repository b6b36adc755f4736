"""Kernel parts: one visit to a tile: relax it with the values of its neighbours, and queue those that it improves."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare, joined
from ppaas.planners.field.kernels.tile_border import (
    beside,
    edge,
    find_neighbours,
    over_corner,
    seen,
    too_long,
    wake_side,
)  # fmt: skip
from ppaas.planners.field.kernels.tile_layout import (
    BOTTOM,
    BOTTOM_LEFT,
    BOTTOM_RIGHT,
    CELLS,
    EDGES,
    FREE,
    KIND,
    LEFT,
    OPEN,
    RIGHT,
    SIDE,
    TABLE,
    TOP,
    TOP_LEFT,
    TOP_RIGHT,
    TOUCHED,
    UNREACHED,
)  # fmt: skip
from ppaas.planners.field.kernels.tile_open import is_open_beside, relax_open
from ppaas.planners.field.kernels.tile_queue import wake
from ppaas.planners.field.kernels.tile_relax import relax
from ppaas.planners.field.kernels.tile_rows import EDGES as SHOWN
from ppaas.planners.field.kernels.tile_rows import (
    KEPT,
    KEYS,
    LAST,
    SELF,
    TILE,
)
from ppaas.planners.kernels import atomics, simd
from ppaas.planners.kernels.prefetch import LINE, fetch

Int = int | np.signedinteger[Any]
Numbers = NDArray[np.uint32]
Bytes = NDArray[np.uint8]

STREAMED = 2048
"""Number of tiles, 8 MB of values, from which the values of open tiles are written past the caches: such a tile is
rarely visited again, and would have been evicted by then. They are written during the next visit."""


@bare
def write_back(field: Numbers, tiles: Int, scratch: Numbers) -> None:
    """Write the values of the tile in scratch memory, if there is one, to the field.

    Other threads see them after the next atomic step of this thread. That step waits for the writes, so it should come
    late.
    """
    kept = np.int64(scratch[KEPT])
    for row in range(SIDE if kept != tiles else 0):
        simd.stream(field, kept * CELLS + row * SIDE, simd.load(scratch, TILE + row * SIDE))
    scratch[KEPT] = tiles


@joined
def _fetch_around(tables: Numbers, tile: Int, scratch: Numbers) -> None:
    """Prefetch the part of the tile's table that a visit writes, and the parts of its neighbours' that it reads."""
    for number in range(EDGES, FREE, LINE):
        fetch(tables, tile * TABLE + number)
    for move in range(8):
        for number in range(FREE, TABLE, LINE):
            fetch(tables, beside(scratch, move) * TABLE + number)


@bare
def visit(
    field: Numbers, tables: Numbers, costs: Bytes, across: Int, tiles: Int, tile: Int, reasons: Int,
    marks: Bytes, words: Numbers, hints: Numbers, places: Numbers, scratch: Numbers, may_keep: bool,
) -> tuple[Int, Int, bool]:  # fmt: skip
    """Visit one tile, and queue the neighbours that it improves.

    The values of the previous tile are written back first. Those of an open tile may stay in scratch memory
    (``scratch[KEPT]`` is then its number); the thread must not release the tile until they are written back.

    Parameters
    ----------
    field, tables, costs, marks, words, hints, places, scratch
        Arrays of the field, as in `ppaas.planners.field.kernels.tile_record`.
    across, tiles : int
        Number of tiles in a row, and in total.
    tile, reasons : int
        Number of the tile, and the bits of the neighbours that woke it.
    may_keep : bool
        Whether its values may stay in scratch memory.

    Returns
    -------
    woken : int
        Number of tiles that were idle and are queued now.
    work : int
        Number of lines processed.
    overlong : bool
        Whether a value exceeds `LIMIT`.
    """
    # Read the surroundings, and write back the previous tile while the prefetches are under way.
    find_neighbours(tile, across, tiles, marks, scratch)
    _fetch_around(tables, tile, scratch)
    write_back(field, tiles, scratch)
    # Relax the tile; open ones by the fast path.
    fresh = seen(scratch, SELF) == tiles
    values, at = field, tile * CELLS
    if tables[tile * TABLE + KIND] == OPEN and is_open_beside(tables, scratch):
        if fresh and tiles >= STREAMED and may_keep:
            values, at = scratch, np.int64(TILE)
            scratch[KEPT] = tile
        work = relax_open(values, at, tables, tile, reasons, fresh, scratch)
    else:
        work = relax(field, tables, costs, tile, reasons, fresh, scratch)
    # Publish its edges, then find out what they improve in each neighbour.
    lines, overlong = _publish_edges(values, at, tables, tile, scratch)
    if fresh:
        atomics.mark(marks, tile, TOUCHED)
    find_neighbours(tile, across, tiles, marks, scratch)
    turned: Int = 0
    for side in range(4):
        scratch[KEYS + side] = UNREACHED
        changed = lines[side]
        if changed:
            values = edge(tables, tile, side)
            scratch[KEYS + side] = wake_side(tables, costs, tile, side, values, scratch)
            if side == TOP:
                turned |= (changed & 1) << TOP_LEFT | (changed >> LAST) << TOP_RIGHT
            if side == BOTTOM:
                turned |= (changed & 1) << BOTTOM_LEFT | (changed >> LAST) << BOTTOM_RIGHT
    for move in range(TOP_LEFT, BOTTOM_RIGHT + 1):
        scratch[KEYS + move] = UNREACHED
        if turned >> move & 1:
            scratch[KEYS + move] = over_corner(tables, costs, tile, move, False, scratch)
    # Queue the improved neighbours.
    woken: Int = 0
    for move in range(8):
        value = np.int64(scratch[KEYS + move])
        if value != UNREACHED:
            other = beside(scratch, move)
            woken += wake(words, hints, places, other, value, move ^ 1 if move < 4 else move ^ 3)
    return woken, work, overlong


@bare
def _publish_edges(values: Numbers, at: Int, tables: Numbers, tile: Int, scratch: Numbers) -> tuple[Any, bool]:
    """Copy the edges of a tile, whose values begin at ``at``, to its table, where neighbours read them.

    Returns
    -------
    changed : tuple of lanes
        Changed cells on each side.
    overlong : bool
        Whether a value exceeds `LIMIT`.
    """
    edges, overlong = tile * TABLE + EDGES, False
    simd.store(scratch, SHOWN + TOP * SIDE, simd.load(values, at))
    simd.store(scratch, SHOWN + BOTTOM * SIDE, simd.load(values, at + LAST * SIDE))
    for row in range(SIDE):
        simd.put(scratch, SHOWN + LEFT * SIDE + row, simd.pick(values, at + row * SIDE))
        simd.put(scratch, SHOWN + RIGHT * SIDE + row, simd.pick(values, at + row * SIDE + LAST))
    lines = (
        _publish_side(tables, edges, TOP, scratch), _publish_side(tables, edges, BOTTOM, scratch),
        _publish_side(tables, edges, LEFT, scratch), _publish_side(tables, edges, RIGHT, scratch),
    )  # fmt: skip
    for side in range(4):
        overlong |= too_long(simd.load(tables, edges + side * SIDE))
    return lines, overlong


@bare
def _publish_side(tables: Numbers, edges: Int, side: Int, scratch: Numbers) -> Int:
    values = simd.load(scratch, SHOWN + side * SIDE)
    changed: Int = simd.unlike(values, edge(tables, seen(scratch, SELF), side))
    simd.store(tables, edges + side * SIDE, values)
    return changed
