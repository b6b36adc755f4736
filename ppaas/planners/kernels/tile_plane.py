"""Kernel parts: a tile spread out for work, twice: row by row and column by column.

A *plane* is a tile with one line more at either end, which belongs to the neighbours there. Lines are rows in the first
plane and columns in the second, so that what moves down and up in the first, moves right and left in the second. The
tile itself has lines 1 to 32. A plane is a part of a thread's scratch memory:

- `LINES`: 34 lines of values.
- `WEIGHTS`, `DIAGONALS`: what its cells weigh, on cardinal and diagonal moves: 32 lines, or one that holds for all.
- `FREE`: which cells of each of the 34 lines are free.
- `LEFT`, `RIGHT`: which of them have a free neighbour at their left, and at their right.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.kernels import simd
from ppaas.planners.kernels.bare import bare, joined
from ppaas.planners.kernels.tile_layout import BASE, FACTOR, HALF, ROOT, ROOT_SHIFT, SIDE, UNKNOWN, UNREACHED

Int = int | np.signedinteger[Any]
Numbers = NDArray[np.uint32]

LINES = 0
WEIGHTS = (SIDE + 2) * SIDE
DIAGONALS = WEIGHTS + SIDE * SIDE
FREE = DIAGONALS + SIDE * SIDE
LEFT = FREE + 48
RIGHT = LEFT + 48
PLANE = RIGHT + 48
ROWS, COLUMNS = np.int64(0), np.int64(PLANE)
"""Where the two planes begin."""
FORTH, BACK = np.int64(1), np.int64(-1)
"""From a line to the next; see `ppaas.planners.kernels.tile_layout` on why these are no numbers of Python."""
BESIDE = 2 * PLANE
"""Behind the planes: the numbers of the tile's eight neighbours, by move."""
SEEN = BESIDE + 8
"""The same, but for those in which nobody has been the number of the outside, which nobody reaches either; last, the
tile itself."""
SELF = np.int64(8)
KEYS = SEEN + 9
"""With what each neighbour is to be woken."""
SPARE = BESIDE + SIDE
"""Behind them: one line more."""
SCRATCH = SPARE + SIDE
"""Numbers in the scratch memory of one thread."""


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


@joined
def _step(scratch: Numbers, plane: Int, line: Int, stride: Int, source: Any, near: Int) -> tuple[Any, Int, Int]:
    """Carry values to a line from the one beside it; return its values, which cells are free and which changed."""
    place, weight = plane + LINES + line * SIDE, plane + WEIGHTS + (line - 1) * stride
    free = simd.pick(scratch, plane + FREE + line)
    left, right = simd.pick(scratch, plane + LEFT + line), simd.pick(scratch, plane + RIGHT + line)
    weights, diagonals = simd.load(scratch, weight), simd.load(scratch, weight + (DIAGONALS - WEIGHTS))
    before = simd.load(scratch, place)
    values = relaxed(source, before, free, near & left, near & right, weights, diagonals)
    simd.store(scratch, place, values)
    return values, free, simd.unlike(values, before)


@bare
def sweep(scratch: Numbers, plane: Int, step: Int, stride: Int, pending: Int) -> tuple[Int, Int, Int]:
    """Carry values from line to line in one direction, as far as they change.

    Parameters
    ----------
    scratch, plane
        Where the plane lies.
    step : int
        `FORTH`, from line 0 on, or `BACK`, from line 33 on.
    stride : int
        From the weights of a line to those of the next: 0 or 32.
    pending : int
        The lines that changed, the lowest bit for the line it begins with.

    Returns
    -------
    changed : int
        The lines that it changed, the lowest bit for the first after that.
    lanes : lanes
        The cells in which any of them changed.
    work : int
        Lines that it did.
    """
    begin = 0 if step > 0 else SIDE + 1
    order = simd.first_lane(pending)
    changed, lanes, work, line, more = 0, 0, 0, begin + step * order, True
    source, free = simd.load(scratch, plane + LINES + line * SIDE), simd.pick(scratch, plane + FREE + line)
    while more:
        line += step
        source, free, different = _step(scratch, plane, line, stride, source, free)
        lanes |= different
        changed |= np.int64(different != 0) << order
        order += 1
        work += 1
        # Lines between two that changed are done too: a branch foretold wrongly costs more than they do.
        more = order < SIDE and (pending >> order | different) != 0
    return changed, lanes, work


@bare
def sweep_through(scratch: Numbers, plane: Int, stride: Int) -> tuple[Int, Int, Int]:
    """Carry values from line to line all the way through, in both directions at once.

    That takes three quarters of the time of one after the other: each step of one way waits for the step before.

    Parameters
    ----------
    scratch, plane, stride
        As in `sweep`.

    Returns
    -------
    forth, back : int
        The lines that changed in each direction, the lowest bit for the first that it came to.
    lanes : lanes
        The cells in which any of them changed.
    """
    forth: Int = 0
    back: Int = 0
    lanes: Int = 0
    down, free_down = simd.load(scratch, plane + LINES), simd.pick(scratch, plane + FREE)
    up, free_up = simd.load(scratch, plane + LINES + (SIDE + 1) * SIDE), simd.pick(scratch, plane + FREE + SIDE + 1)
    for order in range(SIDE):
        down, free_down, moved = _step(scratch, plane, order + 1, stride, down, free_down)
        lanes |= moved
        forth |= np.int64(moved != 0) << order
        up, free_up, moved = _step(scratch, plane, SIDE - order, stride, up, free_up)
        lanes |= moved
        back |= np.int64(moved != 0) << order
    return forth, back, lanes


@bare
def turn(scratch: Numbers, plane: Int, to: Int, lines: Int, lanes: Int) -> None:
    """Copy what changed in some lines and lanes of one plane to the other, by blocks of 16×16."""
    for line in range(0, SIDE, 16):
        for lane in range(0, SIDE, 16):
            if (lines >> line) & 0xFFFF and (lanes >> lane) & 0xFFFF:
                source = plane + LINES + (line + 1) * SIDE + lane
                simd.transpose_block(scratch, source, scratch, to + LINES + (lane + 1) * SIDE + line)
