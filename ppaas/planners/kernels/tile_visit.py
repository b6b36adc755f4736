"""Kernel parts: one visit to a tile: take what its neighbours offer, settle it within, and tell whom to wake."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.kernels import atomics, simd
from ppaas.planners.kernels import tile_plane as plane
from ppaas.planners.kernels.bare import bare, joined
from ppaas.planners.kernels.tile_border import (
    LAST,
    beside,
    edge,
    free_along,
    look_around,
    over_corner,
    seen,
    too_long,
    wake_side,
)  # fmt: skip
from ppaas.planners.kernels.tile_layout import (
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
from ppaas.planners.kernels.tile_open import spread
from ppaas.planners.kernels.tile_plane import (
    BACK,
    COLUMNS,
    FORTH,
    KEYS,
    LINES,
    ROWS,
    SELF,
    slanted,
    sweep,
    sweep_through,
    turn,
    weighed,
)
from ppaas.planners.kernels.tile_queue import wake

Int = int | np.signedinteger[Any]
Numbers = NDArray[np.uint32]
Bytes = NDArray[np.uint8]

MANY = 16
"""If so many lines are pending in both directions, a plane is swept in both at once."""
THROUGH = 50
"""Lines of a sweep in one direction that take as long as a sweep through all in both."""
LATER = 0xFFFF0000
"""Of the lines that one direction changed: those that the other had come to before."""


@bare
def _lay_free(
    scratch: Numbers, to: Int, tables: Numbers, at: Int, before: Int, after: Int, left: Int, right: Int
) -> None:
    """Tell a plane which cells are free: its lines from ``at`` on, those before and after it and beside it."""
    free, one = simd.load(tables, at), simd.splat(1)
    scratch[to + plane.FREE] = before
    simd.store(scratch, to + plane.FREE + 1, free)
    scratch[to + plane.FREE + SIDE + 1] = after
    at_left = simd.both(simd.shift_right(simd.splat(left), simd.ramp()), one)
    at_right = simd.both(simd.shift_right(simd.splat(right), simd.ramp()), one)
    left_of = simd.either(simd.shift_left(free, one), at_left)
    simd.store(scratch, to + plane.LEFT + 1, simd.both(free, left_of))
    right_of = simd.either(simd.shift_right(free, one), simd.shift_left(at_right, simd.splat(LAST)))
    simd.store(scratch, to + plane.RIGHT + 1, simd.both(free, right_of))


@bare
def _lay_weights(scratch: Numbers, costs: Bytes, tables: Numbers, tile: Int) -> Int:
    """Tell both planes what their cells weigh; return how far their lines of weights lie apart."""
    table = tile * TABLE
    first, second = plane.WEIGHTS, COLUMNS + plane.WEIGHTS
    gap = plane.DIAGONALS - plane.WEIGHTS
    if tables[table + KIND] != MIXED:
        weights = weighed(simd.splat(np.int64(tables[table + COST])))
        for at in (first, second):
            simd.store(scratch, at, weights)
            simd.store(scratch, at + gap, slanted(weights))
        return 0
    for row in range(SIDE):
        weights = weighed(simd.load_bytes(costs, tile * CELLS + row * SIDE))
        simd.store(scratch, first + row * SIDE, weights)
        simd.store(scratch, first + gap + row * SIDE, slanted(weights))
    for row in range(0, SIDE, 16):
        for column in range(0, SIDE, 16):
            simd.transpose_block(scratch, first + row * SIDE + column, scratch, second + column * SIDE + row)
    for row in range(SIDE):
        simd.store(scratch, second + gap + row * SIDE, slanted(simd.load(scratch, second + row * SIDE)))
    return SIDE


@bare
def _lay_values(scratch: Numbers, field: Numbers, tile: Int, fresh: bool) -> None:
    """Copy a tile to both planes."""
    none = simd.splat(UNREACHED)
    for row in range(SIDE):
        at = LINES + (row + 1) * SIDE
        if fresh:
            simd.store(scratch, at, none)
            simd.store(scratch, COLUMNS + at, none)
        else:
            simd.store(scratch, at, simd.load(field, tile * CELLS + row * SIDE))
    if not fresh:
        turn(scratch, ROWS, COLUMNS, np.int64(ALL), np.int64(ALL))


@bare
def _enter_corner(scratch: Numbers, tables: Numbers, costs: Bytes, tile: Int, move: Int) -> Int:
    """Take what the neighbour at a corner offers; return whether that is better."""
    value = over_corner(tables, costs, tile, move, True, scratch)
    row = LAST if move in (BOTTOM_LEFT, BOTTOM_RIGHT) else 0
    column = LAST if move in (TOP_RIGHT, BOTTOM_RIGHT) else 0
    if value == UNREACHED:
        return False
    scratch[LINES + (row + 1) * SIDE + column] = value
    scratch[COLUMNS + LINES + (column + 1) * SIDE + row] = value
    return True


@bare
def _sweep_both(scratch: Numbers, at: Int, stride: Int, onward: Int, back: Int) -> tuple[Int, Int, Int, Int, Int]:
    """Sweep one plane in both directions; return the lines and lanes that changed, what is pending and lines done."""
    moved: Int = 0
    lanes: Int = 0
    work: Int = 0
    if simd.size(onward) >= MANY and simd.size(back) >= MANY:
        forth, against, lanes = sweep_through(scratch, at, stride)
        onward, back = _after(simd.mirrored(against & LATER)), _after(simd.mirrored(forth & LATER))
        return forth | simd.mirrored(against), lanes, onward, back, THROUGH
    if onward:
        moved, lanes, work = sweep(scratch, at, FORTH, stride, onward)
        back |= _after(simd.mirrored(moved))
    onward = 0
    if back:
        changed, where, done = sweep(scratch, at, BACK, stride, back)
        changed = simd.mirrored(changed)
        onward = _after(changed)
        moved, lanes, work = moved | changed, lanes | where, work + done
    return moved, lanes, onward, 0, work


@joined
def _after(lines: Int) -> Int:
    """Return what is pending for a sweep when these lines of the tile changed, in its order."""
    return (lines << 1) & ALL


@bare
def _settle(scratch: Numbers, stride: Int, down: Int, up: Int, right: Int, left: Int) -> tuple[Int, Int]:
    """Sweep both planes until nothing changes; return the rows that changed, and the lines done."""
    rows: Int = 0
    work: Int = 0
    while down | up | right | left:
        moved, lanes, down, up, done = _sweep_both(scratch, ROWS, stride, down, up)
        turn(scratch, ROWS, COLUMNS, moved, lanes)
        right |= _after(lanes)
        left |= _after(simd.mirrored(lanes))
        rows |= moved
        work += done
        moved, lanes, right, left, done = _sweep_both(scratch, COLUMNS, stride, right, left)
        turn(scratch, COLUMNS, ROWS, moved, lanes)
        down |= _after(lanes)
        up |= _after(simd.mirrored(lanes))
        rows |= lanes
        work += done
    return rows, work


@bare
def _work_off(
    field: Numbers, tables: Numbers, costs: Bytes, tile: Int, reasons: Int, fresh: bool, scratch: Numbers
) -> Int:
    """Settle a tile within and keep its values; return the lines done."""
    above, below, before, after = (
        beside(scratch, TOP),
        beside(scratch, BOTTOM),
        beside(scratch, LEFT),
        beside(scratch, RIGHT),
    )
    sides = (
        free_along(tables, above, BOTTOM), free_along(tables, below, TOP),
        free_along(tables, before, RIGHT), free_along(tables, after, LEFT),
    )  # fmt: skip
    free = tile * TABLE + FREE
    _lay_free(scratch, ROWS, tables, free, sides[0], sides[1], sides[2], sides[3])
    _lay_free(scratch, COLUMNS, tables, free + SIDE, sides[2], sides[3], sides[0], sides[1])
    stride = _lay_weights(scratch, costs, tables, tile)
    _lay_values(scratch, field, tile, fresh)
    beyond = LINES + (SIDE + 1) * SIDE
    simd.store(scratch, LINES, edge(tables, seen(scratch, TOP), BOTTOM))
    simd.store(scratch, beyond, edge(tables, seen(scratch, BOTTOM), TOP))
    simd.store(scratch, COLUMNS + LINES, edge(tables, seen(scratch, LEFT), RIGHT))
    simd.store(scratch, COLUMNS + beyond, edge(tables, seen(scratch, RIGHT), LEFT))
    down, up, right, left = reasons & 1, (reasons >> 1) & 1, (reasons >> 2) & 1, (reasons >> 3) & 1
    rows: Int = 0
    if (reasons >> GOAL) & 1:
        down = up = right = left = ALL
    for move in range(TOP_LEFT, BOTTOM_RIGHT + 1):
        if (reasons >> move) & 1 and _enter_corner(scratch, tables, costs, tile, move):
            rows |= 1 | 1 << LAST
            down |= 2 if move in (TOP_LEFT, TOP_RIGHT) else 0
            up |= 2 if move in (BOTTOM_LEFT, BOTTOM_RIGHT) else 0
            right |= 2 if move in (TOP_LEFT, BOTTOM_LEFT) else 0
            left |= 2 if move in (TOP_RIGHT, BOTTOM_RIGHT) else 0
    changed: Int
    work: Int
    changed, work = _settle(scratch, stride, down, up, right, left)
    rows = ALL if fresh else rows | changed
    while rows != 0:
        row = simd.first_lane(rows)
        rows &= rows - 1
        simd.store(field, tile * CELLS + row * SIDE, simd.load(scratch, LINES + (row + 1) * SIDE))
    return work


@bare
def visit(
    field: Numbers, tables: Numbers, costs: Bytes, across: Int, tiles: Int, tile: Int, reasons: Int,
    marks: Bytes, words: Numbers, hints: Numbers, scratch: Numbers,
) -> tuple[Int, Int, bool]:  # fmt: skip
    """Work on one tile, and wake its neighbours."""
    look_around(tile, across, tiles, marks, scratch)
    fresh = seen(scratch, SELF) == tiles
    if tables[tile * TABLE + KIND] == OPEN:
        work = spread(field, tables, tile, reasons, fresh, scratch)
    else:
        work = _work_off(field, tables, costs, tile, reasons, fresh, scratch)
    lines, overlong = _show(tables, tile, scratch)
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
            woken += wake(words, hints, other, value, move ^ 1 if move < 4 else move ^ 3)
    return woken, work, overlong


@bare
def _show(tables: Numbers, tile: Int, scratch: Numbers) -> tuple[Any, bool]:
    """Let the neighbours see the tile's edges; return the lanes that changed on each side."""
    edges, overlong = tile * TABLE + EDGES, False
    lines = (
        _show_side(tables, edges, TOP, scratch), _show_side(tables, edges, BOTTOM, scratch),
        _show_side(tables, edges, LEFT, scratch), _show_side(tables, edges, RIGHT, scratch),
    )  # fmt: skip
    for side in range(4):
        overlong |= too_long(simd.load(tables, edges + side * SIDE))
    return lines, overlong


@bare
def _show_side(tables: Numbers, edges: Int, side: Int, scratch: Numbers) -> Int:
    line = SIDE if side in (BOTTOM, RIGHT) else 1
    values = simd.load(scratch, (COLUMNS if side in (LEFT, RIGHT) else ROWS) + LINES + line * SIDE)
    changed: Int = simd.unlike(values, edge(tables, seen(scratch, SELF), side))
    simd.store(tables, edges + side * SIDE, values)
    return changed
