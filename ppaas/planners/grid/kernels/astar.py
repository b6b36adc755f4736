"""Kernel: grow a field of costs from its goal towards one cell: A* (Hart, Nilsson and Raphael, 1968).

What is left from a cell to the target is estimated by the octile distance at the least weights there are. No move
lowers value and estimate together (the estimate is consistent), so a cell is worked off with its final value, but for
the few that a bucket wider than one takes too early: their value falls again, and they are worked off again.

A cell's element of the field is ``base`` + 2·value, and 1 more while it waits in the queue; so one comparison with what
is written tells whether a new value is less, and what searches before have left is never less.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.grid.kernels.bucket_ring import BUCKET, MARKS, RING_STATE, SHIFT, SIZE, SLOTS, empty, pop, push
from ppaas.planners.kernels.jit_decorators import bare
from ppaas.planners.kernels.moves import EXHAUSTED, NEEDS, PAUSED, POOL_EMPTY, SETTLED

Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]
Links = NDArray[np.int32]

COUNT, BEST, EXTRA_STATE = RING_STATE, RING_STATE + 1, 2
"""Behind the ring's state: cells settled, −1 before the search has begun; the least value of the target so far."""

UNKNOWN_YET = np.int64(1 << 62)

DOWN = (0, 0, -1, 1, -1, -1, 1, 1)
RIGHT = (-1, 1, 0, 0, -1, 1, -1, 1)
"""Rows and columns that each move leads on; diagonal moves last, so that they are taken from a bucket first."""


@bare
def octile(down: int, right: int, cardinal: int, diagonal: int) -> int:
    """Return the least that any path over so many rows and columns can weigh."""
    down, right = abs(down), abs(right)
    return int(min(down, right) * diagonal + abs(down - right) * cardinal)


@bare
def divide(cell: int, stride: int) -> tuple[int, int]:
    """Return row and column of an element; unsigned and short, which is the fastest division there is."""
    row = int(np.int64(np.uint32(cell) // np.uint32(stride)))
    return row, cell - row * stride


@bare
def aim(
    field: Ints, costs: Bytes, stride: int, weights: Ints, least: Ints,
    heads: Links, marks: NDArray[np.uint64], pool: Links, state: Ints,
    base: int, ceiling: int, goal: int, target: int, budget: int,
) -> int:  # fmt: skip
    """Work off up to ``budget`` cells and tell why it stopped.

    Parameters
    ----------
    field : (n,) int64 array
        Values; see above.
    costs : (n,) uint8 array
        Costs of the padded map.
    stride : int
        Elements in a row of it.
    weights : (2, 256) int64 array
        What a cardinal and a diagonal move into a cell of each cost weighs; 0 is blocked.
    least : (2,) int64 array
        The least of both.
    heads, marks, pool, state
        The queue, and what the search remembers.
    base, ceiling : int
        Both even; what is written in this search is from the one to below the other, what was written before is above.
    goal, target : int
        Cell to begin at, and cell whose value is wanted.
    budget : int
        Cells to work off before it pauses.

    Returns
    -------
    int
        EXHAUSTED, SETTLED, PAUSED or POOL_EMPTY.
    """
    target_row, target_column = divide(target, stride)
    if state[COUNT] < 0:
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
        if waiting & 1 == 0:
            continue
        value = (waiting - base) >> 1
        row, column = divide(cell, stride)
        if value + octile(row - target_row, column - target_column, least[0], least[1]) >= state[BEST]:
            continue
        field[cell] = waiting - 1
        state[COUNT] += 1
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
                state[COUNT] -= 1  # it is to be settled again
            field[neighbour] = element
            push(heads, marks, pool, state, neighbour, new + left)


@bare
def walk(
    field: Ints, costs: Bytes, stride: int, weights: Ints, base: int, cells: Links, count: int, budget: int
) -> int:
    """Go on with a path to the goal for up to ``budget`` cells; return how many it has now.

    From each cell it goes to a neighbour of which the cell has its value; straight on where it may, so that of all
    cheapest paths one with few turns is taken.

    Parameters
    ----------
    field, costs, stride, weights, base
        As in `aim`, which must have settled the first cell of the path.
    cells : (m, 2) int32 array
        Row, column on the map; rows up to ``count`` are filled, at least one.
    count : int
        Cells so far.
    budget : int
        Most cells to add.
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
