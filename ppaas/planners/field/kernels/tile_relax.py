"""Kernel part: relax a tile: moves from its neighbours, then sweeps until nothing changes within it."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare, joined
from ppaas.planners.field.kernels.tile_border import (
    beside,
    crossed,
    edge,
    free_along,
    over_corner,
    seen,
)  # fmt: skip
from ppaas.planners.field.kernels.tile_layout import (
    ALL,
    BOTTOM,
    BOTTOM_LEFT,
    BOTTOM_RIGHT,
    CELLS,
    COST,
    FREE,
    GOAL,
    KIND,
    LEFT,
    MIXED,
    RIGHT,
    SIDE,
    TABLE,
    TOP,
    TOP_LEFT,
    TOP_RIGHT,
    UNREACHED,
)  # fmt: skip
from ppaas.planners.field.kernels.tile_rows import (
    BACK,
    DIAGONALS,
    ENTER_LEFT,
    ENTER_RIGHT,
    FORTH,
    LAST,
    SELF,
    SUMS,
    WEIGHTS,
    slanted,
    store_runs,
    sweep,
    weighed,
)
from ppaas.planners.kernels import simd

Int = int | np.signedinteger[Any]
Numbers = NDArray[np.uint32]
Bytes = NDArray[np.uint8]


@bare
def _store_weights(scratch: Numbers, costs: Bytes, tables: Numbers, tile: Int) -> Int:
    """Store the weights of a tile's cells in scratch memory; return the offset between those of two rows."""
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
    """Apply the moves from the neighbour on the left or right; return the rows that they improve."""
    values, before = edge(tables, seen(scratch, side), side ^ 1), edge(tables, seen(scratch, SELF), side)
    near = free_along(tables, beside(scratch, side), side ^ 1)
    after = crossed(tables, costs, tile, side, values, near, before, scratch)
    simd.store(scratch, ENTER_LEFT if side == LEFT else ENTER_RIGHT, after)
    better: Int = simd.less(after, before)
    return better


@bare
def _enter_corner(tables: Numbers, costs: Bytes, tile: Int, move: Int, scratch: Numbers) -> Int:
    """Apply the diagonal move from the neighbour at a corner; return the row that it improves, as a bit set."""
    value = over_corner(tables, costs, tile, move, True, scratch)
    row = LAST if move in (BOTTOM_LEFT, BOTTOM_RIGHT) else 0
    at = (ENTER_RIGHT if move in (TOP_RIGHT, BOTTOM_RIGHT) else ENTER_LEFT) + row
    if value == UNREACHED:
        return 0
    simd.put(scratch, at, min(value, simd.pick(scratch, at)))
    return 1 << row


@bare
def _enter(tables: Numbers, costs: Bytes, tile: Int, reasons: Int, scratch: Numbers) -> Int:
    """Apply the moves from all neighbours except those above and below; return the improved rows."""
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
    """Return the rows that the sweep in the other direction must process after these changed, in its order."""
    pending: Int = (simd.mirrored(rows) << 1) & ALL
    return pending


@bare
def _sweep_tile(
    field: Numbers, tables: Numbers, tile: Int, stride: Int, reasons: Int, rows: Int, scratch: Numbers
) -> Int:
    """Sweep a tile down and up until nothing changes; ``rows`` are those that values enter from beside.

    Returns
    -------
    int
        Number of lines processed.
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
def relax(field: Numbers, tables: Numbers, costs: Bytes, tile: Int, reasons: Int, fresh: bool, scratch: Numbers) -> Int:
    """Relax a tile until nothing changes within it; return the number of lines processed.

    Parameters
    ----------
    field, tables, costs, scratch
        Arrays of the field, as in `ppaas.planners.field.kernels.tile_record`.
    tile, reasons : int
        Number of the tile, and the bits of the neighbours that woke it.
    fresh : bool
        Whether the tile is visited for the first time, so that its values are uninitialized.
    """
    store_runs(scratch, simd.load(tables, tile * TABLE + FREE))
    stride = _store_weights(scratch, costs, tables, tile)
    for row in range(SIDE if fresh else 0):
        simd.store(field, tile * CELLS + row * SIDE, simd.splat(UNREACHED))
    rows = _enter(tables, costs, tile, reasons, scratch)
    work: Int = _sweep_tile(field, tables, tile, stride, reasons, rows, scratch)
    return work
