"""Kernel parts: the rows of a tile, swept down and up until nothing changes.

A *sweep* carries values from row to row in one direction. Each row that it betters is then settled along itself as
well: where a step to the left or right betters anything, values are carried along the whole row at once, as far as its
cells are free. So one sweep finds all ways that never turn back up, or down, however often they turn aside.

Values stay where they are, in the field. What else a sweep needs of a tile lies in a thread's scratch memory:

- `EDGES`: its top row, bottom row, left column and right column, as they are after the work.
- `FREE`: which cells of each row are free.
- `RIGHTWARD`, `LEFTWARD`: of each row the free cells with a free one before them, on the left or right, then those
  with 2, 4, 8 and 16.
- `WEIGHTS`, `DIAGONALS`: what its cells weigh, on cardinal and diagonal moves: 32 rows, or one that holds for all.
- `SUMS`: if one holds for all, what the first 1, 2, … 32 cells of a row weigh together.
- `ENTER_LEFT`, `ENTER_RIGHT`: values that come into each row at its ends, from beside the tile.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.field.kernels.tile_layout import BASE, FACTOR, HALF, ROOT, ROOT_SHIFT, SIDE, UNKNOWN, UNREACHED
from ppaas.planners.kernels import simd
from ppaas.planners.kernels.jit_decorators import bare, joined

Int = int | np.signedinteger[Any]
Numbers = NDArray[np.uint32]

LAST = SIDE - 1

EDGES = 0
FREE = 4 * SIDE
RIGHTWARD = FREE + SIDE
LEFTWARD = RIGHTWARD + 5 * SIDE
WEIGHTS = LEFTWARD + 5 * SIDE
DIAGONALS = WEIGHTS + SIDE * SIDE
SUMS = DIAGONALS + SIDE * SIDE
ENTER_LEFT = SUMS + SIDE
ENTER_RIGHT = ENTER_LEFT + SIDE
BESIDE = ENTER_RIGHT + SIDE
"""Behind them: the numbers of the tile's eight neighbours, by move."""
SEEN = BESIDE + 8
"""The same, but for those in which nobody has been the number of the outside, which nobody reaches either; last, the
tile itself."""
SELF = np.int64(8)
KEYS = SEEN + 9
"""With what each neighbour is to be woken."""
SPARE = BESIDE + SIDE
"""Behind them: four rows more."""
KEPT = KEYS + 8
"""The tile whose values lie behind `TILE`; the number of the outside if they are no tile's."""
TILE = SPARE + 4 * SIDE
"""Behind them: the values of a tile that is settled, which go to the field when the next is worked on."""
CHANGES = TILE + SIDE * SIDE
"""Behind them: eight rows for `ppaas.planners.field.kernels.tile_groups`."""
SCRATCH = -(-(CHANGES + 8 * SIDE) // (2 * SIDE)) * 2 * SIDE
"""Numbers in the scratch memory of one thread: whole lines of memory."""

FORTH, BACK = np.int64(1), np.int64(-1)
"""From a row to the next; see `ppaas.planners.field.kernels.tile_layout` on why these are no numbers of Python."""
MOST = 1 << 20
"""More than the cells of a row weigh together, and less than what is left above `UNREACHED`."""


@joined
def relaxed(source: Any, target: Any, free: Int, left: Int, right: Int, weights: Any, diagonals: Any) -> Any:
    """Return the values of a line after all moves into it from the line beside it.

    Parameters
    ----------
    source, target : row
        Values of the two lines.
    free : lanes
        Free cells of the target.
    left, right : lanes
        Those of them into which a diagonal move may come from the left, and from the right.
    weights, diagonals : row
        What the cells of the target weigh.
    """
    none = simd.splat(UNREACHED)
    from_left = simd.where(left, simd.from_left(source, UNREACHED), none)
    from_right = simd.where(right, simd.from_right(source, UNREACHED), none)
    straight = simd.where(free, simd.add(source, weights), none)
    return simd.least(simd.least(target, straight), simd.add(simd.least(from_left, from_right), diagonals))


@joined
def weighed(costs: Any) -> Any:
    """Return what cells of these costs weigh."""
    known = simd.add(simd.multiply(costs, simd.splat(FACTOR)), simd.splat(BASE))
    return simd.where(simd.unlike(costs, simd.splat(255)), known, simd.splat(UNKNOWN))


@joined
def slanted(weights: Any) -> Any:
    """Return what diagonal moves into cells of these weights weigh."""
    product = simd.add(simd.multiply(weights, simd.splat(ROOT)), simd.splat(HALF))
    return simd.shift_right(product, simd.splat(ROOT_SHIFT))


@bare
def lay_runs(scratch: Numbers, free: Any) -> None:
    """Tell which cells of each row are free, and before how long runs of free cells they lie."""
    simd.store(scratch, FREE, free)
    rightward, leftward = free, free
    for doubling in range(5):
        by = simd.splat(max(1, (1 << doubling) >> 1))
        rightward = simd.both(rightward, simd.shift_left(rightward, by))
        leftward = simd.both(leftward, simd.shift_right(leftward, by))
        simd.store(scratch, RIGHTWARD + doubling * SIDE, rightward)
        simd.store(scratch, LEFTWARD + doubling * SIDE, leftward)


@joined
def _moved_right(values: Any, sums: Any, scratch: Numbers, row: Int) -> Any:
    """Return what moves to the right along a row give, however many.

    A move from one cell to a later one weighs the difference of their sums, so what is least after them is what was
    least less its own sum. To stay above 0, that is `MOST` more.
    """
    by_sum = simd.subtract(simd.splat(MOST), sums)
    at = RIGHTWARD + row
    least = simd.least_up_to_in(
        simd.add(values, by_sum), simd.pick(scratch, at), simd.pick(scratch, at + SIDE),
        simd.pick(scratch, at + 2 * SIDE), simd.pick(scratch, at + 3 * SIDE), simd.pick(scratch, at + 4 * SIDE),
    )  # fmt: skip
    return simd.subtract(least, by_sum)


@joined
def _moved_left(values: Any, sums: Any, weights: Any, scratch: Numbers, row: Int) -> Any:
    """Return the same for moves to the left: they weigh what lies before each cell, less what lies before the last."""
    before = simd.subtract(sums, weights)
    at = LEFTWARD + row
    least = simd.least_from_in(
        simd.add(values, before), simd.pick(scratch, at), simd.pick(scratch, at + SIDE),
        simd.pick(scratch, at + 2 * SIDE), simd.pick(scratch, at + 3 * SIDE), simd.pick(scratch, at + 4 * SIDE),
    )  # fmt: skip
    return simd.subtract(least, before)


@joined
def _settled_along(values: Any, weights: Any, stride: Int, scratch: Numbers, row: Int) -> Any:
    """Return the values of a row after all moves along it."""
    none = simd.splat(UNREACHED)
    from_left = simd.where(simd.pick(scratch, RIGHTWARD + row), simd.from_left(values, UNREACHED), none)
    from_right = simd.where(simd.pick(scratch, LEFTWARD + row), simd.from_right(values, UNREACHED), none)
    if simd.less(simd.add(simd.least(from_left, from_right), weights), values):
        sums = simd.sum_up_to(weights) if stride else simd.load(scratch, SUMS)
        rightward = _moved_right(values, sums, scratch, row)
        values = simd.least(rightward, _moved_left(values, sums, weights, scratch, row))
    return values


@joined
def _entered(values: Any, scratch: Numbers, row: Int) -> Any:
    """Return the values of a row with what comes into it from beside the tile."""
    at_right = simd.where(1 << LAST, simd.splat(simd.pick(scratch, ENTER_RIGHT + row)), simd.splat(UNREACHED))
    return simd.least(values, simd.where(1, simd.splat(simd.pick(scratch, ENTER_LEFT + row)), at_right))


@bare
def sweep(
    field: Numbers,
    at: Int,
    scratch: Numbers,
    step: Int,
    stride: Int,
    source: Any,
    near: Int,
    pending: Int,
    entered: Int,
) -> tuple[Int, Int]:
    """Carry values from row to row in one direction, as far as they change.

    Parameters
    ----------
    field : uint32 array
    at : int
        Where the tile begins.
    scratch : uint32 array
    step : int
        `FORTH`, from the first row on, or `BACK`, from the last.
    stride : int
        From the weights of a row to those of the next: 0 or 32.
    source : row
        Values of the row before the tile, in that direction.
    near : lanes
        Free cells of that row.
    pending : int
        The rows to be done, the lowest bit for the one it begins with.
    entered : int
        Those of them that something comes into from beside.

    Returns
    -------
    changed : int
        The rows that it changed, the lowest bit for the one it begins with.
    work : int
        Rows that it did.
    """
    order = simd.first_lane(pending)
    row = order if step > 0 else LAST - order
    if order:
        source, near = simd.load(field, at + (row - step) * SIDE), simd.pick(scratch, FREE + row - step)
    changed, work, more = 0, 0, True
    while more:
        right, left = near & simd.pick(scratch, RIGHTWARD + row), near & simd.pick(scratch, LEFTWARD + row)
        near = simd.pick(scratch, FREE + row)
        weights, diagonals = simd.load(scratch, WEIGHTS + row * stride), simd.load(scratch, DIAGONALS + row * stride)
        before = simd.load(field, at + row * SIDE)
        enters = entered >> order & 1
        target = _entered(before, scratch, row) if enters else before
        values = relaxed(source, target, near, right, left, weights, diagonals)
        different = simd.less(values, before) | enters
        # As a branch: what is foretold rightly need not wait for the row before.
        if different:
            source = _settled_along(values, weights, stride, scratch, row)
            simd.store(field, at + row * SIDE, source)
            changed |= 1 << order
        else:
            source = before
        order += 1
        row += step
        work += 1
        # Rows between two that changed are done too: a branch foretold wrongly costs more than they do.
        more = order < SIDE and (pending >> order | different) != 0
    return changed, work
