"""Kernel: jump point search (Harabor and Grastien, 2011) without corner cutting (2012, 2014), also on weighted maps.

Of all cheapest paths that differ only in the order of their moves, only the one with its diagonal moves first is
followed. This symmetry requires that the neighbours of a cell weigh the same. At a *mixed* cell they do not; from there
a path may continue to every neighbour that the previous cell does not reach at less cost (after Carlson et al.,
"Optimal Pathfinding on Weighted Grid Maps", 2023). The heuristic is that of A*. The moves differ: the search takes
whole jumps, and the straight jumps beside a diagonal one at once.

A cell may be reached from several sides with the same value, each with other directions to continue in. All of them are
followed: a node stores a set of directions, and is expanded again if more are added. So the search finds all cheapest
paths of the kind above, also in case of ties.

The search grows from the goal towards the start, like cost fields: a move weighs as much as the cell entered. All cells
entered in one jump weigh the same, because of any two successive cells at least one is not mixed.

A node is two numbers per cell: ``base`` + value, and parent · 2¹⁶ + directions followed · 2⁸ + directions still to
follow. The path from a node to its parent is straight first, then diagonal.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare, inlined
from ppaas.planners.grid.kernels.astar import UNKNOWN_YET, divide, octile
from ppaas.planners.grid.kernels.bucket_ring import BUCKET, MARKS, RING_STATE, SHIFT, SIZE, SLOTS, empty, pop, push
from ppaas.planners.grid.kernels.jump_planes import AHEAD, BACK, MIXED, SQUARE
from ppaas.planners.grid.kernels.jump_turns import ANY, DOWN, RIGHT, turns
from ppaas.planners.grid.kernels.jump_turns import MIXED as IN_MIXED
from ppaas.planners.kernels.bits import first_from, is_set, last_until, three_at
from ppaas.planners.kernels.moves import EXHAUSTED, PAUSED, POOL_EMPTY, SETTLED
from ppaas.planners.units import CARDINAL, DIAGONAL

Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]
Links = NDArray[np.int32]
Words = NDArray[np.uint64]
Query = tuple[int, int, int, int, int, int, int, int, int]
"""Parameters of a query: base; row and column of the target; cells in a row; weight of the cheapest cardinal move; bits
in a plane of the rows; first bit of the planes of the columns; bits in a column; bits in a plane of the columns."""

COUNT, BEST, WORK, EXTRA_STATE = RING_STATE, RING_STATE + 1, RING_STATE + 2, 3
"""Elements of the state behind the ring's: expansions, −1 before the search has begun; least value of the target so
far; words scanned."""

LONGEST = 64
"""Maximum number of moves of a diagonal jump. It then ends in a node, which is expanded later if it leads away from the
target."""

_TURNS = turns().ravel()
_PARENT, _SET = 16, 255


@inlined
def _arrive(
    planes: Words, nodes: Ints, heads: Links, marks: Words, pool: Links, state: Ints, query: Query,
    row: int, column: int, value: int, came: int, parent: int,
) -> None:  # fmt: skip
    """End a jump in a cell: update its node, and queue it if it has new directions to follow."""
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
    """Jump from a cell in one of the directions 0 to 3, by scanning 64 cells per word."""
    _, target_row, target_column, stride, _, plane, columns, height, turned = query
    if direction & 1:
        # Along a column; the planes of the columns are behind those of the rows.
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
    """Jump from a cell in any direction; from each cell of a diagonal jump also jump in its two straight directions."""
    _, target_row, target_column, stride, _, plane, _, _, _ = query
    is_diagonal = direction > 3
    down, right = DOWN[direction], RIGHT[direction]
    diagonal = weight // CARDINAL * DIAGONAL
    # First bit of the 2×2 square that a diagonal move crosses, relative to the cell.
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
    """Expand cells, scanning about ``budget`` words, and return why the kernel stopped.

    Parameters
    ----------
    planes : (words,) uint64 array
        Bit planes of `ppaas.planners.grid.kernels.jump_planes`, of the rows and then of the columns.
    costs : (n,) uint8 array
        Costs of the padded map.
    weights : (256,) int64 array
        Weight of a cardinal move into a cell of each cost; 0 is blocked.
    nodes : (n, 2) int64 array
        Nodes as described in the module. In and out.
    heads, marks, pool, state
        Queue (`ppaas.planners.grid.kernels.bucket_ring`) and state of the search. In and out.
    query : tuple of int
        See `Query`.
    goal : int
        Cell where the search begins.
    room : int
        Maximum number of queue entries that expanding one cell adds.
    budget : int
        Number of words to scan in this call, up to one expansion more.

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
    """Extend a path by about ``budget`` cells, along the parents of nodes.

    Parameters
    ----------
    nodes, stride
        As in `jump`.
    node : int
        Cell of the padded map that the path has reached; it must be a reached node.
    cells : (m, 2) int32 array
        Row, column on the map; rows up to ``count`` are filled. It must have room for the budget plus a jump.
    count : int
        Length of the path so far, without the node.
    budget : int
        Number of cells to add, up to a jump more.

    Returns
    -------
    node : int
        Cell that the path has reached now; −1 at its end.
    count : int
        Its new length.
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
            # Move along the longer axis only, until both distances are equal; then diagonally.
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
