"""Kernel part: relax a tile without obstacles whose cells all cost the same.

Between two cells of such a tile a cheapest path has its diagonal moves first, then its cardinal ones. One sweep down
and one up, which include what enters from the sides, and one pass along each row then find all values. The edges tell
which sweeps are needed.

A path that enters from a side can begin with diagonal moves only if the cells beside them are free. A tile next to a
partly blocked side is therefore relaxed like any other.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare, joined
from ppaas.planners.field.kernels.tile_border import beside, edge, free_along, seen, value_at
from ppaas.planners.field.kernels.tile_layout import (
    ALL,
    BOTTOM,
    BOTTOM_LEFT,
    BOTTOM_RIGHT,
    COST,
    GOAL,
    LEFT,
    RIGHT,
    SIDE,
    TABLE,
    TOP,
    TOP_LEFT,
    TOP_RIGHT,
    UNREACHED,
)  # fmt: skip
from ppaas.planners.field.kernels.tile_rows import BACK, FORTH, LAST, SELF, SPARE, slanted, weighed
from ppaas.planners.kernels import simd

Int = int | np.signedinteger[Any]
Numbers = NDArray[np.uint32]

FROM_LEFT, FROM_RIGHT, BESIDE_LEFT, BESIDE_RIGHT = (SPARE + SIDE * line for line in range(4))
"""Lines of scratch memory: for each row, the values beside it that may enter by diagonal and by straight moves."""

FROM_ABOVE = 1 << TOP | 1 << TOP_LEFT | 1 << TOP_RIGHT | 1 << GOAL
FROM_BELOW = 1 << BOTTOM | 1 << BOTTOM_LEFT | 1 << BOTTOM_RIGHT | 1 << GOAL


@joined
def is_open_beside(tables: Numbers, scratch: Numbers) -> bool:
    """Return whether the cells beside the tile on its left are all free or all blocked, and those on its right too."""
    left = free_along(tables, beside(scratch, LEFT), RIGHT)
    right = free_along(tables, beside(scratch, RIGHT), LEFT)
    return left in (0, ALL) and right in (0, ALL)


@joined
def _enters(slanting: Any, straight: Any, edge_values: Any, weights: Any, diagonals: Any) -> bool:
    """Return whether a diagonal move from beside the tile gives a lower value than a straight one."""
    return bool(simd.less(simd.add(slanting, diagonals), simd.least(simd.add(straight, weights), edge_values)))


@joined
def _stepped(source: Any, before: Any, at_left: Int, at_right: Int, free: Int, weights: Any, diagonals: Any) -> Any:
    slanting = simd.least(simd.from_left(source, at_left), simd.from_right(source, at_right))
    slanting = simd.where(free, slanting, simd.splat(UNREACHED))
    return simd.least(before, simd.least(simd.add(source, weights), simd.add(slanting, diagonals)))


@bare
def _sweep_open(
    field: Numbers, at: Int, step: Int, source: Any, free: Int, weights: Any, diagonals: Any, fresh: bool,
    scratch: Numbers,
) -> None:  # fmt: skip
    """Propagate values from row to row through the whole tile; ``free`` are the free cells of the source row."""
    row: Int = 0 if step > 0 else LAST
    for _ in range(SIDE):
        before = simd.splat(UNREACHED) if fresh else simd.load(field, at + row * SIDE)
        at_left, at_right = simd.pick(scratch, FROM_LEFT + row), simd.pick(scratch, FROM_RIGHT + row)
        source = _stepped(source, before, at_left, at_right, free, weights, diagonals)
        simd.store(field, at + row * SIDE, source)
        free = ALL
        row += step


@bare
def _relax_rows(values: Numbers, at: Int, weight: Int, scratch: Numbers) -> None:
    """Propagate values along each row in both directions, by prefix minima."""
    weights = simd.splat(weight)
    rising = simd.multiply(simd.ramp(), weights)
    falling = simd.subtract(simd.splat(LAST * weight), rising)
    for row in range(SIDE):
        line = simd.load(values, at + row * SIDE)
        moved = simd.least(
            simd.from_left(line, simd.pick(scratch, BESIDE_LEFT + row)),
            simd.from_right(line, simd.pick(scratch, BESIDE_RIGHT + row)),
        )
        moved = simd.add(moved, weights)
        if simd.less(moved, line):
            line = simd.least(line, moved)
            rightward = simd.subtract(simd.least_up_to(simd.add(line, falling)), falling)
            leftward = simd.subtract(simd.least_from(simd.add(line, rising)), rising)
            line = simd.least(rightward, leftward)
            simd.store(values, at + row * SIDE, line)


@bare
def _sweep_if_needed(
    values: Numbers, at: Int, tables: Numbers, step: Int, woken: Int, fresh: bool, weights: Any, diagonals: Any,
    scratch: Numbers,
) -> Int:  # fmt: skip
    """Propagate values down or up, with what enters from both sides, if that improves any; return the lines done.

    A diagonal move from beside the tile improves a value only if it improves one in the edge column: if a straight move
    gives as little in each row of that column, it does so for all cells behind it as well.
    """
    down = step > 0
    left, right = edge(tables, seen(scratch, LEFT), RIGHT), edge(tables, seen(scratch, RIGHT), LEFT)
    corner = seen(scratch, TOP_LEFT if down else BOTTOM_LEFT)
    at_left = value_at(tables, corner, BOTTOM_RIGHT if down else TOP_RIGHT)
    corner = seen(scratch, TOP_RIGHT if down else BOTTOM_RIGHT)
    at_right = value_at(tables, corner, BOTTOM_LEFT if down else TOP_LEFT)
    from_left = simd.from_left(left, at_left) if down else simd.from_right(left, at_left)
    from_right = simd.from_left(right, at_right) if down else simd.from_right(right, at_right)
    from_left = simd.where(free_along(tables, beside(scratch, LEFT), RIGHT), from_left, simd.splat(UNREACHED))
    from_right = simd.where(free_along(tables, beside(scratch, RIGHT), LEFT), from_right, simd.splat(UNREACHED))
    enters = _enters(from_left, left, edge(tables, seen(scratch, SELF), LEFT), weights, diagonals)
    enters |= _enters(from_right, right, edge(tables, seen(scratch, SELF), RIGHT), weights, diagonals)
    if not woken and not enters:
        return 0
    simd.store(scratch, FROM_LEFT, from_left)
    simd.store(scratch, FROM_RIGHT, from_right)
    facing = BOTTOM if down else TOP
    source = edge(tables, seen(scratch, TOP if down else BOTTOM), facing)
    free = free_along(tables, beside(scratch, TOP if down else BOTTOM), facing)
    _sweep_open(values, at, step, source, free, weights, diagonals, fresh, scratch)
    return SIDE


@bare
def relax_open(
    values: Numbers, at: Int, tables: Numbers, tile: Int, reasons: Int, fresh: bool, scratch: Numbers
) -> Int:
    """Relax an open tile; return half the lines done, since they take half the time of those of other tiles.

    Parameters
    ----------
    values : uint32 array
        Array that holds the tile's values. In and out.
    at : int
        Index of its first value; if ``fresh``, the values are uninitialized.
    tables, tile, reasons, scratch
        As in `ppaas.planners.field.kernels.tile_growth`.
    fresh : bool
        Whether the tile is visited for the first time.
    """
    weights = weighed(simd.splat(np.int64(tables[tile * TABLE + COST])))
    diagonals = slanted(weights)
    work: Int = _sweep_if_needed(values, at, tables, FORTH, reasons & FROM_ABOVE, fresh, weights, diagonals, scratch)
    fresh &= work == 0
    work += _sweep_if_needed(values, at, tables, BACK, reasons & FROM_BELOW, fresh, weights, diagonals, scratch)
    if fresh and work == 0:
        for row in range(SIDE):
            simd.store(values, at + row * SIDE, simd.splat(UNREACHED))
    simd.store(scratch, BESIDE_LEFT, edge(tables, seen(scratch, LEFT), RIGHT))
    simd.store(scratch, BESIDE_RIGHT, edge(tables, seen(scratch, RIGHT), LEFT))
    _relax_rows(values, at, np.int64(simd.least_of(weights)), scratch)
    return (work + SIDE) >> 1
