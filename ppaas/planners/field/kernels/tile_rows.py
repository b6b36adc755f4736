"""Kernel parts: sweeps over the rows of a tile, down and up until nothing changes.

A *sweep* propagates values from row to row in one direction. Each row that it improves is then relaxed along itself:
if a step to the left or right improves anything, values are propagated along the whole row at once, within its runs of
free cells. One sweep thus finds all paths that never turn back up (or down), with any number of turns sideways.

The values themselves are in the field. The scratch memory of a thread holds the rest:

- `EDGES`: values of the tile's top row, bottom row, left column and right column after the visit.
- `FREE`: bit set of the free cells of each row.
- `RIGHTWARD`, `LEFTWARD`: for each row the free cells with at least 1 free cell before them, on the left or right; then
  those with at least 2, 4, 8 and 16.
- `WEIGHTS`, `DIAGONALS`: weights of cardinal and diagonal moves into its cells: 32 rows, or one that applies to all.
- `SUMS`: prefix sums of the weights of a row, if one applies to all rows.
- `ENTER_LEFT`, `ENTER_RIGHT`: values that enter each row at its ends, from beside the tile.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare, joined
from ppaas.planners.field.kernels.tile_layout import BASE, FACTOR, HALF, ROOT, ROOT_SHIFT, SIDE, UNKNOWN, UNREACHED
from ppaas.planners.kernels import simd

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
"""Offset of the numbers of the tile's eight neighbours, by move."""
SEEN = BESIDE + 8
"""Offset of the same numbers for reading values: unvisited neighbours are replaced by the outside tile, whose values
are all unreached; the ninth is the tile itself."""
SELF = np.int64(8)
"""Index of the tile itself in `SEEN`."""
KEYS = SEEN + 9
"""Offset of the values with which the neighbours are to be woken."""
SPARE = BESIDE + SIDE
"""Offset of four more rows."""
KEPT = KEYS + 8
"""Offset of the number of the tile whose values are in `TILE`; the number of the outside tile if there is none."""
TILE = SPARE + 4 * SIDE
"""Offset of the values of a finished tile, which are written to the field during the next visit."""
CHANGES = TILE + SIDE * SIDE
"""Offset of eight rows for `ppaas.planners.field.kernels.tile_groups`."""
SCRATCH = -(-(CHANGES + 8 * SIDE) // (2 * SIDE)) * 2 * SIDE
"""Length of the scratch memory of one thread [uint32 numbers], a multiple of the cache line."""

FORTH, BACK = np.int64(1), np.int64(-1)
"""Step from a row to the next; numpy integers for the reason given in `ppaas.planners.field.kernels.tile_layout`."""
MOST = 1 << 20
"""Offset that keeps prefix sums positive: more than the weight of a whole row, and less than 2³² − `UNREACHED`."""


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
        Those of them that a diagonal move may enter from the left, and from the right.
    weights, diagonals : row
        Weights of cardinal and diagonal moves into the cells of the target.
    """
    none = simd.splat(UNREACHED)
    from_left = simd.where(left, simd.from_left(source, UNREACHED), none)
    from_right = simd.where(right, simd.from_right(source, UNREACHED), none)
    straight = simd.where(free, simd.add(source, weights), none)
    return simd.least(simd.least(target, straight), simd.add(simd.least(from_left, from_right), diagonals))


@joined
def weighed(costs: Any) -> Any:
    """Return the weights of cells with these costs."""
    known = simd.add(simd.multiply(costs, simd.splat(FACTOR)), simd.splat(BASE))
    return simd.where(simd.unlike(costs, simd.splat(255)), known, simd.splat(UNKNOWN))


@joined
def slanted(weights: Any) -> Any:
    """Return the weights of diagonal moves into cells of these weights."""
    product = simd.add(simd.multiply(weights, simd.splat(ROOT)), simd.splat(HALF))
    return simd.shift_right(product, simd.splat(ROOT_SHIFT))


@bare
def store_runs(scratch: Numbers, free: Any) -> None:
    """Store the free cells of each row, and the lengths of the runs of free cells before them, by doubling."""
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
    """Return the values of a row after any number of moves to the right.

    The path from one cell to a later one weighs the difference of their prefix sums S. The new value of cell j is
    therefore S(j) + min over i ≤ j of (value(i) − S(i)): a prefix minimum. `MOST` keeps the differences positive.
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
    """Return the same for moves to the left, whose weight is the difference of the sums before the two cells."""
    before = simd.subtract(sums, weights)
    at = LEFTWARD + row
    least = simd.least_from_in(
        simd.add(values, before), simd.pick(scratch, at), simd.pick(scratch, at + SIDE),
        simd.pick(scratch, at + 2 * SIDE), simd.pick(scratch, at + 3 * SIDE), simd.pick(scratch, at + 4 * SIDE),
    )  # fmt: skip
    return simd.subtract(least, before)


@joined
def _relaxed_along(values: Any, weights: Any, stride: Int, scratch: Numbers, row: Int) -> Any:
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
    """Return the values of a row with those that enter at its ends from beside the tile."""
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
    """Propagate values from row to row in one direction, as long as they change.

    Parameters
    ----------
    field : uint32 array
        In and out.
    at : int
        Index of the tile's first value.
    scratch : uint32 array
    step : int
        `FORTH`, from the first row on, or `BACK`, from the last.
    stride : int
        Offset from the weights of a row to those of the next: 0 or 32.
    source : row
        Values of the row before the tile, in that direction.
    near : lanes
        Free cells of that row.
    pending : int
        Bit set of the rows to process; the lowest bit is the first row in that direction.
    entered : int
        Those of them that values enter from beside the tile.

    Returns
    -------
    changed : int
        Bit set of the changed rows, in the same order.
    work : int
        Number of rows processed.
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
        # A branch, not a select: if predicted correctly, it does not wait for the previous row.
        if different:
            source = _relaxed_along(values, weights, stride, scratch, row)
            simd.store(field, at + row * SIDE, source)
            changed |= 1 << order
        else:
            source = before
        order += 1
        row += step
        work += 1
        # Rows between two changed ones are processed too: a mispredicted branch costs more.
        more = order < SIDE and (pending >> order | different) != 0
    return changed, work
