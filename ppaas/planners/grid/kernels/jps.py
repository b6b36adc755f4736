"""Kernel: jump point search (Harabor and Grastien, 2011) where no corner is cut (2012, 2014), on weighted maps too.

Of all cheapest paths that differ only in the order of their moves one is followed, the one with its diagonal moves
first. That needs the neighbours of a cell to weigh alike. At a mixed cell, where they do not, a path may go on wherever
the cell before does not lead for less (after Carlson and others, "Optimal Pathfinding on Weighted Grid Maps", 2023).
What is left is estimated as in A*, from which this differs in its moves: whole jumps, and from a diagonal jump the
straight ones beside it at once.

A cell may be come to from several sides with the same value, and go on in other directions from each. All of them are
followed: a cell waits with a set of directions, and is worked off again if more are found. So each cheapest path of
the kind above is found, whatever ties there are.

A search grows from the goal towards the start, as fields do: a move weighs what the cell entered weighs. All cells
entered in one jump weigh the same, for between any two that follow each other there is one that is not mixed.

A node is two numbers for each cell: ``base`` + value, and parent · 2¹⁶ + directions followed · 2⁸ + directions still to
follow. To the parent a path leads straight and then diagonally.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.grid.kernels.astar import UNKNOWN_YET, divide, octile
from ppaas.planners.grid.kernels.bucket_ring import BUCKET, MARKS, RING_STATE, SHIFT, SIZE, SLOTS, empty, pop, push
from ppaas.planners.grid.kernels.jump_planes import AHEAD, BACK, MIXED, SQUARE
from ppaas.planners.grid.kernels.jump_turns import ANY, DOWN, RIGHT, turns
from ppaas.planners.grid.kernels.jump_turns import MIXED as IN_MIXED
from ppaas.planners.kernels.bits import first_from, is_set, last_until, three_at
from ppaas.planners.kernels.jit_decorators import bare, inlined
from ppaas.planners.kernels.moves import EXHAUSTED, PAUSED, POOL_EMPTY, SETTLED
from ppaas.planners.units import CARDINAL, DIAGONAL

Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]
Links = NDArray[np.int32]
Words = NDArray[np.uint64]
Query = tuple[int, int, int, int, int, int, int, int, int]
"""Base; row and column of the target; cells in a row; what the cheapest cardinal move weighs; bits in a plane of the
rows; where the planes of the columns begin; bits in a column; bits in a plane of the columns."""

COUNT, BEST, WORK, EXTRA_STATE = RING_STATE, RING_STATE + 1, RING_STATE + 2, 3
"""Behind the ring's state: cells worked off, −1 before the search has begun; the least value of the target so far;
looks at words."""

LONGEST = 64
"""Moves of a diagonal jump, at most: after that it goes on as a new one, which waits its turn if it leads away."""

_TURNS = turns().ravel()
_PARENT, _SET = 16, 255


@inlined
def _arrive(
    planes: Words, nodes: Ints, heads: Links, marks: Words, pool: Links, state: Ints, query: Query,
    row: int, column: int, value: int, came: int, parent: int,
) -> None:  # fmt: skip
    """Let a jump end in a cell."""
    base, target_row, target_column, stride, least, plane, _, _, _ = query
    cell = row * stride + column
    place = np.uint64(cell)
    known = nodes[place, 0]
    if base + value > known:
        return
    left = octile(row - target_row, column - target_column, least, least // CARDINAL * DIAGONAL)
    if value + left >= state[BEST]:
        return
    if left == 0:
        state[BEST] = value
        nodes[place, 0], nodes[place, 1] = base + value, parent << _PARENT
        return
    if came != ANY and is_set(planes, MIXED * plane + cell):
        came += IN_MIXED
    around = three_at(planes, cell - stride) | (three_at(planes, cell) << 3) | (three_at(planes, cell + stride) << 6)
    into = np.int64(_TURNS[np.uint64((came << 9) + around)])
    if base + value < known:
        nodes[place, 0], nodes[place, 1] = base + value, parent << _PARENT | into
        push(heads, marks, pool, state, cell, value + left)
        return
    known = nodes[place, 1]
    more = into & ~(known | known >> 8) & _SET
    nodes[place, 1] = known | more
    if more and not known & _SET:
        push(heads, marks, pool, state, cell, value + left)


@inlined
def _jump_straight(
    planes: Words, nodes: Ints, heads: Links, marks: Words, pool: Links, state: Ints, query: Query,
    row: int, column: int, value: int, direction: int, weight: int, parent: int,
) -> None:  # fmt: skip
    """Jump from a cell in one of the directions 0 to 3."""
    _, target_row, target_column, stride, _, plane, columns, height, turned = query
    if direction & 1:
        # Along a column: its planes lie behind those of the rows.
        line, size, at, target_at = columns + column * height, turned, row, target_row
        in_line = column == target_column
    else:
        line, size, at, target_at = row * stride, plane, column, target_column
        in_line = row == target_row
    if direction < 2:
        line += AHEAD * size
        far = first_from(planes, line + at + 1) - line - at
        passed = in_line and at < target_at <= at + far
    else:
        line += BACK * size
        far = at + line - last_until(planes, line + at - 1)
        passed = in_line and at - far <= target_at < at
    if passed:
        far = abs(target_at - at)
    state[WORK] += 1 + (far >> 6)
    end_row, end_column = row + DOWN[direction] * far, column + RIGHT[direction] * far
    if is_set(planes, end_row * stride + end_column):
        _arrive(
            planes, nodes, heads, marks, pool, state, query,
            end_row, end_column, value + far * weight, direction, parent,
        )  # fmt: skip


@inlined
def _jump(
    planes: Words, nodes: Ints, heads: Links, marks: Words, pool: Links, state: Ints, query: Query,
    row: int, column: int, value: int, direction: int, weight: int, parent: int,
) -> None:  # fmt: skip
    """Jump from a cell in any direction: if diagonally, then straight on from each cell on the way as well."""
    _, target_row, target_column, stride, _, plane, _, _, _ = query
    is_diagonal = direction > 3
    down, right = DOWN[direction], RIGHT[direction]
    diagonal = weight // CARDINAL * DIAGONAL
    # The corner of the square of four cells that a diagonal move leads over.
    corner = SQUARE * plane + min(down, 0) * stride + min(right, 0)
    for step in range(1, LONGEST + 1):
        if is_diagonal:
            if not is_set(planes, corner + row * stride + column):
                break
            row, column, value = row + down, column + right, value + diagonal
            at_target = row == target_row and column == target_column
            if at_target or step == LONGEST or is_set(planes, MIXED * plane + row * stride + column):
                _arrive(planes, nodes, heads, marks, pool, state, query, row, column, value, direction, parent)
                break
        for side in range(1 + is_diagonal):
            straight = (direction + side) & 3
            _jump_straight(
                planes, nodes, heads, marks, pool, state, query, row, column, value, straight, weight, parent
            )
        if not is_diagonal:
            break


@bare
def jump(
    planes: Words, costs: Bytes, weights: Ints, nodes: Ints,
    heads: Links, marks: Words, pool: Links, state: Ints, query: Query, goal: int, room: int, budget: int,
) -> int:  # fmt: skip
    """Work off cells with about ``budget`` looks at words and tell why it stopped.

    Parameters
    ----------
    planes : (words,) uint64 array
        The planes of `ppaas.planners.grid.kernels.jump_planes`, of rows and then of columns.
    costs : (n,) uint8 array
        Costs of the padded map.
    weights : (256,) int64 array
        What a cardinal move into a cell of each cost weighs.
    nodes : (n, 2) int64 array
        See above.
    heads, marks, pool, state
        The queue, and what the search remembers.
    query : tuple of int
    goal : int
        Cell to begin at.
    room : int
        Entries of the pool that working off one cell can take.
    budget : int

    Returns
    -------
    int
        EXHAUSTED, SETTLED, PAUSED or POOL_EMPTY.
    """
    base, target_row, target_column, stride, least, _, _, _, _ = query
    if state[COUNT] < 0:
        state[COUNT], state[WORK], state[BEST] = 0, 0, UNKNOWN_YET
        row, column = divide(goal, stride)
        empty(
            heads, marks, state, octile(row - target_row, column - target_column, least, least // CARDINAL * DIAGONAL)
        )
        _arrive(planes, nodes, heads, marks, pool, state, query, row, column, 0, ANY, goal)
    end = state[WORK] + budget
    while True:
        if state[WORK] >= end:
            return PAUSED
        if state[SIZE] + room >= pool.shape[0]:
            return POOL_EMPTY
        cell = int(pop(heads, marks, pool, state))
        if cell < 0 or state[BUCKET] << state[SHIFT] >= state[BEST]:
            return SETTLED if state[BEST] < UNKNOWN_YET else EXHAUSTED
        place = np.uint64(cell)
        into = nodes[place, 1] & _SET
        if into == 0:
            continue
        nodes[place, 1] ^= into | into << 8
        value = nodes[place, 0] - base
        row, column = divide(cell, stride)
        left = octile(row - target_row, column - target_column, least, least // CARDINAL * DIAGONAL)
        if value + left >= state[BEST]:
            continue
        state[COUNT] += 1
        state[WORK] += 1
        for direction in range(8):
            if not into >> direction & 1:
                continue
            weight = weights[costs[np.uint64(cell + DOWN[direction] * stride + RIGHT[direction])]]
            _jump(planes, nodes, heads, marks, pool, state, query, row, column, value, direction, weight, cell)


@bare
def unwind(nodes: Ints, stride: int, node: int, cells: Links, count: int, budget: int) -> tuple[int, int]:
    """Go on with a path for about ``budget`` cells; return at which node it is then, −1 at its end, and its length.

    Parameters
    ----------
    nodes, stride
        As in `jump`.
    node : int
        Cell that the path has come to, as it is in the padded map; it was reached.
    cells : (m, 2) int32 array
        Row, column on the map; rows up to ``count`` are filled. There must be room for the budget and a jump more.
    count : int
        Cells so far, without that of the node.
    budget : int
    """
    end = count + budget
    row, column = divide(node, stride)
    while count < end:
        parent = nodes[node, 1] >> _PARENT
        end_row, end_column = divide(parent, stride)
        while row != end_row or column != end_column:
            cells[count, 0], cells[count, 1] = row - 1, column - 1
            count += 1
            down, right = end_row - row, end_column - column
            # Straight until it is as far down as right.
            if abs(down) >= abs(right):
                row += np.sign(down)
            if abs(right) >= abs(down):
                column += np.sign(right)
        if parent == node:
            cells[count, 0], cells[count, 1] = row - 1, column - 1
            return -1, count + 1
        node = parent
    return node, count


def warm() -> None:
    """Compile and call each kernel once."""
    planes, nodes, state = (
        np.zeros(4, np.uint64),
        np.zeros((256, 2), np.int64),
        np.zeros(RING_STATE + EXTRA_STATE, np.int64),
    )
    state[COUNT] = -1
    queue = np.zeros(SLOTS, np.int32), np.zeros(MARKS, np.uint64), np.empty((16, 2), np.int32), state
    query = (-100, 1, 2, 64, CARDINAL, 0, 0, 64, 0)
    jump(planes, np.zeros(256, np.uint8), np.zeros(256, np.int64), nodes, *queue, query, 65, 8, 9)
    nodes[65, 1] = 65 << _PARENT
    unwind(nodes, 64, 65, np.empty((1, 2), np.int32), 0, 1)
