"""Kernel parts: one visit to a tile: take what its neighbours offer, settle it within, and tell whom to wake."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.field.kernels.tile_border import (
    beside,
    crossed,
    edge,
    free_along,
    look_around,
    over_corner,
    seen,
    too_long,
    wake_side,
)  # fmt: skip
from ppaas.planners.field.kernels.tile_layout import (
    ALL,
    BOTTOM,
    BOTTOM_LEFT,
    BOTTOM_RIGHT,
    CELLS,
    COST,
    EDGES,
    FREE,
    GOAL,
    KIND,
    LEFT,
    MIXED,
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
from ppaas.planners.field.kernels.tile_open import is_open_beside, spread
from ppaas.planners.field.kernels.tile_queue import wake
from ppaas.planners.field.kernels.tile_rows import (
    BACK,
    DIAGONALS,
    ENTER_LEFT,
    ENTER_RIGHT,
    FORTH,
    KEPT,
    KEYS,
    LAST,
    SELF,
    SUMS,
    TILE,
    WEIGHTS,
    lay_runs,
    slanted,
    sweep,
    weighed,
)
from ppaas.planners.field.kernels.tile_rows import EDGES as SHOWN
from ppaas.planners.kernels import atomics, simd
from ppaas.planners.kernels.jit_decorators import bare, joined
from ppaas.planners.kernels.prefetch import LINE, fetch

Int = int | np.signedinteger[Any]
Numbers = NDArray[np.uint32]
Bytes = NDArray[np.uint8]

STREAMED = 2048
"""Tiles of a field, 8 MB, from which on the values of an open one are written past the caches: it is hardly ever come
back to, and would not be there any more. They are written while the next tile is worked on."""


@bare
def _lay_weights(scratch: Numbers, costs: Bytes, tables: Numbers, tile: Int) -> Int:
    """Lay out what the cells of a tile weigh; return how far the weights of its rows lie apart."""
    table = tile * TABLE
    if tables[table + KIND] != MIXED:
        weights = weighed(simd.splat(np.int64(tables[table + COST])))
        simd.store(scratch, WEIGHTS, weights)
        simd.store(scratch, DIAGONALS, slanted(weights))
        simd.store(scratch, SUMS, simd.sum_up_to(weights))
        return 0
    for row in range(SIDE):
        weights = weighed(simd.load_bytes(costs, tile * CELLS + row * SIDE))
        simd.store(scratch, WEIGHTS + row * SIDE, weights)
        simd.store(scratch, DIAGONALS + row * SIDE, slanted(weights))
    return SIDE


@bare
def _enter_side(tables: Numbers, costs: Bytes, tile: Int, side: Int, scratch: Numbers) -> Int:
    """Take what the neighbour on the left or right offers; return the rows in which that is better."""
    values, before = edge(tables, seen(scratch, side), side ^ 1), edge(tables, seen(scratch, SELF), side)
    near = free_along(tables, beside(scratch, side), side ^ 1)
    after = crossed(tables, costs, tile, side, values, near, before, scratch)
    simd.store(scratch, ENTER_LEFT if side == LEFT else ENTER_RIGHT, after)
    better: Int = simd.less(after, before)
    return better


@bare
def _enter_corner(tables: Numbers, costs: Bytes, tile: Int, move: Int, scratch: Numbers) -> Int:
    """Take what the neighbour at a corner offers; return the row in which that is better, if it is."""
    value = over_corner(tables, costs, tile, move, True, scratch)
    row = LAST if move in (BOTTOM_LEFT, BOTTOM_RIGHT) else 0
    at = (ENTER_RIGHT if move in (TOP_RIGHT, BOTTOM_RIGHT) else ENTER_LEFT) + row
    if value == UNREACHED:
        return 0
    simd.put(scratch, at, min(value, simd.pick(scratch, at)))
    return 1 << row


@bare
def _enter(tables: Numbers, costs: Bytes, tile: Int, reasons: Int, scratch: Numbers) -> Int:
    """Take what all neighbours but those above and below offer; return the rows in which something is better."""
    for to in (ENTER_LEFT, ENTER_RIGHT):
        simd.store(scratch, to, simd.splat(UNREACHED))
    rows: Int = ALL if (reasons >> GOAL) & 1 else 0
    for side in (LEFT, RIGHT):
        if (reasons >> side) & 1:
            rows |= _enter_side(tables, costs, tile, side, scratch)
    for move in range(TOP_LEFT, BOTTOM_RIGHT + 1):
        if (reasons >> move) & 1:
            rows |= _enter_corner(tables, costs, tile, move, scratch)
    return rows


@joined
def _after(rows: Int) -> Int:
    """Return which rows are pending for the sweep the other way when these changed, in its order."""
    pending: Int = (simd.mirrored(rows) << 1) & ALL
    return pending


@bare
def _settle(field: Numbers, tables: Numbers, tile: Int, stride: Int, reasons: Int, rows: Int, scratch: Numbers) -> Int:
    """Sweep a tile until nothing changes; ``rows`` are those that something comes into from beside.

    Returns
    -------
    int
        Lines done.
    """
    at = tile * CELLS
    above, below = edge(tables, seen(scratch, TOP), BOTTOM), edge(tables, seen(scratch, BOTTOM), TOP)
    near_above = free_along(tables, beside(scratch, TOP), BOTTOM)
    near_below = free_along(tables, beside(scratch, BOTTOM), TOP)
    down: Int = (reasons >> TOP) & 1
    up: Int = (reasons >> BOTTOM) & 1
    work: Int = 0
    entered_down, entered_up = (0, simd.mirrored(rows)) if up and not down else (rows, 0)
    down |= entered_down
    up |= entered_up
    while down | up:
        if down:
            changed, done = sweep(field, at, scratch, FORTH, stride, above, near_above, down, entered_down)
            up |= _after(changed)
            down, entered_down, work = 0, 0, work + done
        if up:
            changed, done = sweep(field, at, scratch, BACK, stride, below, near_below, up, entered_up)
            down = _after(changed)
            up, entered_up, work = 0, 0, work + done
    return work


@bare
def _work_off(
    field: Numbers, tables: Numbers, costs: Bytes, tile: Int, reasons: Int, fresh: bool, scratch: Numbers
) -> Int:
    """Settle a tile within; return the lines done."""
    lay_runs(scratch, simd.load(tables, tile * TABLE + FREE))
    stride = _lay_weights(scratch, costs, tables, tile)
    for row in range(SIDE if fresh else 0):
        simd.store(field, tile * CELLS + row * SIDE, simd.splat(UNREACHED))
    rows = _enter(tables, costs, tile, reasons, scratch)
    work: Int = _settle(field, tables, tile, stride, reasons, rows, scratch)
    return work


@bare
def put_down(field: Numbers, tiles: Int, scratch: Numbers) -> None:
    """Write the values of a tile that a thread keeps, if it keeps any, to the field.

    Others see them after the next atomic step of this thread, which waits until they are written: much is to be done
    before that comes.
    """
    kept = np.int64(scratch[KEPT])
    for row in range(SIDE if kept != tiles else 0):
        simd.stream(field, kept * CELLS + row * SIDE, simd.load(scratch, TILE + row * SIDE))
    scratch[KEPT] = tiles


@joined
def _fetch_around(tables: Numbers, tile: Int, scratch: Numbers) -> None:
    """Fetch what a visit writes to the table of its tile, and reads of those around even if nobody has been there."""
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
    """Work on one tile, and wake its neighbours; what was kept of another is put down.

    Whether its own values are kept is in the scratch memory then. As long as they are, nobody else may work on it.
    """
    look_around(tile, across, tiles, marks, scratch)
    _fetch_around(tables, tile, scratch)
    put_down(field, tiles, scratch)
    fresh = seen(scratch, SELF) == tiles
    values, at = field, tile * CELLS
    if tables[tile * TABLE + KIND] == OPEN and is_open_beside(tables, scratch):
        if fresh and tiles >= STREAMED and may_keep:
            values, at = scratch, np.int64(TILE)
            scratch[KEPT] = tile
        work = spread(values, at, tables, tile, reasons, fresh, scratch)
    else:
        work = _work_off(field, tables, costs, tile, reasons, fresh, scratch)
    lines, overlong = _show(values, at, tables, tile, scratch)
    if fresh:
        atomics.mark(marks, tile, TOUCHED)
    look_around(tile, across, tiles, marks, scratch)
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
    woken: Int = 0
    for move in range(8):
        value = np.int64(scratch[KEYS + move])
        if value != UNREACHED:
            other = beside(scratch, move)
            woken += wake(words, hints, places, other, value, move ^ 1 if move < 4 else move ^ 3)
    return woken, work, overlong


@bare
def _show(values: Numbers, at: Int, tables: Numbers, tile: Int, scratch: Numbers) -> tuple[Any, bool]:
    """Let the neighbours see the edges of a tile, whose values lie from ``at`` on.

    Returns
    -------
    changed : lanes
        That changed on each side.
    overlong : bool
        Whether a value there is so large that others may be too large for the field.
    """
    edges, overlong = tile * TABLE + EDGES, False
    simd.store(scratch, SHOWN + TOP * SIDE, simd.load(values, at))
    simd.store(scratch, SHOWN + BOTTOM * SIDE, simd.load(values, at + LAST * SIDE))
    for row in range(SIDE):
        simd.put(scratch, SHOWN + LEFT * SIDE + row, simd.pick(values, at + row * SIDE))
        simd.put(scratch, SHOWN + RIGHT * SIDE + row, simd.pick(values, at + row * SIDE + LAST))
    lines = (
        _show_side(tables, edges, TOP, scratch), _show_side(tables, edges, BOTTOM, scratch),
        _show_side(tables, edges, LEFT, scratch), _show_side(tables, edges, RIGHT, scratch),
    )  # fmt: skip
    for side in range(4):
        overlong |= too_long(simd.load(tables, edges + side * SIDE))
    return lines, overlong


@bare
def _show_side(tables: Numbers, edges: Int, side: Int, scratch: Numbers) -> Int:
    values = simd.load(scratch, SHOWN + side * SIDE)
    changed: Int = simd.unlike(values, edge(tables, seen(scratch, SELF), side))
    simd.store(tables, edges + side * SIDE, values)
    return changed
