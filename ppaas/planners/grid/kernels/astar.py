"""Kernel: grow a cost field from its goal towards one cell by A* (Hart, Nilsson and Raphael, 1968).

The heuristic is the octile distance to the target with the least weights of the map. It is consistent, so cells are
expanded with their final value, except for a few that a bucket of width above 1 yields too early: their value falls
again, and they are expanded again.

The element of a cell is ``base`` + 2·value, plus 1 while it is queued. A single comparison with the element tells
whether a new value is lower, because elements of earlier searches are never lower (see
`ppaas.planners.grid.search_memory`).
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare
from ppaas.planners.grid.kernels.bucket_ring import BUCKET, MARKS, RING_STATE, SHIFT, SIZE, SLOTS, empty, pop, push
from ppaas.planners.kernels.moves import EXHAUSTED, NEEDS, PAUSED, POOL_EMPTY, SETTLED

Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]
Links = NDArray[np.int32]

COUNT, BEST, EXTRA_STATE = RING_STATE, RING_STATE + 1, 2
"""Elements of the state behind the ring's: number of settled cells, −1 before the search has begun; least value of the
target so far."""

UNKNOWN_YET = np.int64(1 << 62)
"""Value of a target that has not been reached."""

DOWN = (0, 0, -1, 1, -1, -1, 1, 1)
RIGHT = (-1, 1, 0, 0, -1, 1, -1, 1)
"""Rows and columns of each move. Diagonal moves are last, so that they are popped from a bucket first."""


@bare
def octile(down: int, right: int, cardinal: int, diagonal: int) -> int:
    """Return the octile distance: the least weight of a path over a number of rows and columns."""
    down, right = abs(down), abs(right)
    return int(min(down, right) * diagonal + abs(down - right) * cardinal)


@bare
def divide(cell: int, stride: int) -> tuple[int, int]:
    """Return row and column of an element; 32-bit unsigned division is the fastest."""
    row = int(np.int64(np.uint32(cell) // np.uint32(stride)))
    return row, cell - row * stride


@bare
def aim(
    field: Ints, costs: Bytes, stride: int, weights: Ints, least: Ints,
    heads: Links, marks: NDArray[np.uint64], pool: Links, state: Ints,
    base: int, ceiling: int, goal: int, target: int, budget: int,
) -> int:  # fmt: skip
    """Expand up to ``budget`` cells and return why the kernel stopped.

    Parameters
    ----------
    field : (n,) int64 array
        Elements as described in the module. In and out.
    costs : (n,) uint8 array
        Costs of the padded map.
    stride : int
        Number of elements in a row.
    weights : (2, 256) int64 array
        Weight of a cardinal and of a diagonal move into a cell of each cost; 0 is blocked.
    least : (2,) int64 array
        Least weight of both kinds of moves on this map.
    heads, marks, pool, state
        Queue (`ppaas.planners.grid.kernels.bucket_ring`) and state of the search. In and out.
    base, ceiling : int
        Range of the elements of this search: base ≤ element < ceiling. Both are even; older elements are above.
    goal, target : int
        Cell where the field begins, and cell whose value is wanted.
    budget : int
        Number of cells to expand in this call.

    Returns
    -------
    int
        EXHAUSTED, SETTLED, PAUSED or POOL_EMPTY.
    """
    target_row, target_column = divide(target, stride)
    if state[COUNT] < 0:  # first call: queue the goal
        row, column = divide(goal, stride)
        left = octile(row - target_row, column - target_column, least[0], least[1])
        empty(heads, marks, state, left)
        push(heads, marks, pool, state, goal, left)
        field[goal] = base + 1
        state[COUNT], state[BEST] = 0, 0 if goal == target else UNKNOWN_YET
    end = state[COUNT] + budget
    while True:
        if state[COUNT] >= end:
            return PAUSED
        if state[SIZE] + 8 >= pool.shape[0]:
            return POOL_EMPTY
        cell = int(pop(heads, marks, pool, state))
        if cell < 0 or state[BUCKET] << state[SHIFT] >= state[BEST]:
            return SETTLED if state[BEST] < UNKNOWN_YET else EXHAUSTED
        waiting = field[cell]
        if waiting & 1 == 0:  # a stale entry: expanded already
            continue
        value = (waiting - base) >> 1
        row, column = divide(cell, stride)
        if value + octile(row - target_row, column - target_column, least[0], least[1]) >= state[BEST]:
            continue
        field[cell] = waiting - 1
        state[COUNT] += 1
        # Relax the moves to its free neighbours; prune those that cannot lead to a better path to the target.
        open_sides = 0
        for move in range(8):
            if open_sides & NEEDS[move] != NEEDS[move]:
                continue
            neighbour = cell + DOWN[move] * stride + RIGHT[move]
            weight = weights[move >> 2, costs[neighbour]]
            if weight == 0:
                continue
            open_sides |= (1 << move) & 15
            new = value + weight
            element = base + (new << 1) + 1
            old = field[neighbour]
            if element >= old:
                continue
            left = octile(row + DOWN[move] - target_row, column + RIGHT[move] - target_column, least[0], least[1])
            if new + left >= state[BEST]:
                continue
            if neighbour == target:
                state[BEST] = new
            if old < ceiling and old & 1 == 0:
                state[COUNT] -= 1  # it was settled and will be again
            field[neighbour] = element
            push(heads, marks, pool, state, neighbour, new + left)


@bare
def walk(
    field: Ints, costs: Bytes, stride: int, weights: Ints, base: int, cells: Links, count: int, budget: int
) -> int:
    """Extend a path to the goal by up to ``budget`` cells; return its new length.

    Each step goes to a neighbour n with value(n) + weight of the move = value(cell). It keeps the direction of the last
    step if possible, which selects one of the cheapest paths with few turns.

    Parameters
    ----------
    field, costs, stride, weights, base
        As in `aim`, which must have settled the first cell of the path.
    cells : (m, 2) int32 array
        Row, column on the map. Rows up to ``count``, at least one, are filled. In and out.
    count : int
        Length of the path so far.
    budget : int
        Maximum number of cells to add.
    """
    row, column = np.int64(cells[count - 1, 0]), np.int64(cells[count - 1, 1])
    ahead = 0
    if count > 1:
        for move in range(8):
            if DOWN[move] == row - cells[count - 2, 0] and RIGHT[move] == column - cells[count - 2, 1]:
                ahead = move
    for _ in range(budget):
        here = (row + 1) * stride + column + 1
        value = (field[here] - base) >> 1
        found = -1
        for attempt in range(9):
            move = ahead if attempt == 0 else attempt - 1
            down, right = DOWN[move] * stride, RIGHT[move]
            if weights[0, costs[here + down]] == 0 or weights[0, costs[here + right]] == 0:
                continue
            below = (field[here + down + right] - base) >> 1
            if below + weights[move >> 2, costs[here]] == value:
                found = move
                break
        if found < 0:
            break
        ahead = found
        row += DOWN[found]
        column += RIGHT[found]
        cells[count, 0] = row
        cells[count, 1] = column
        count += 1
    return count


def warm() -> None:
    """Compile and call each kernel once."""
    field, costs = np.zeros(12, np.int64), np.ones(12, np.uint8)
    costs[5:7] = 0
    weights, least = np.zeros((2, 256), np.int64), np.ones(2, np.int64)
    weights[:, 0] = least
    state = np.zeros(RING_STATE + EXTRA_STATE, np.int64)
    state[COUNT] = -1
    queue = np.zeros(SLOTS, np.int32), np.zeros(MARKS, np.uint64), np.empty((16, 2), np.int32), state
    aim(field, costs, 4, weights, least, *queue, -100, 0, 5, 6, 9)
    walk(field, costs, 4, weights, -100, np.array([[0, 1], [0, 0]], np.int32), 1, 1)
