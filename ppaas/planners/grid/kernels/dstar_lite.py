"""Kernels: keep a field of costs-to-go right while the map changes and the robot moves: D* Lite.

Source: Koenig and Likhachev, "D* Lite", 2002, in its optimized version (figure 4). Each cell has two values: the one it
had when it was last worked off (g in the paper, ``field`` here), and the one that follows from its neighbours' (rhs,
``ahead`` here). Cells of which the two differ wait in a heap, those first that may concern the robot's way. Only they
are worked off; what a change does not reach is not touched.

Both values are costs-to-go in fixed point plus ``AT_GOAL``, as in `ppaas.planners.field.kernels.layout`. No move leads
to or past a blocked cell, so a cell that becomes blocked is taken out at once: its neighbours are all that it concerns.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.planners.field.kernels.layout import AT_GOAL, BLOCKED
from ppaas.planners.kernels.indexed_heap import drop, put
from ppaas.planners.kernels.moves import EXHAUSTED, NEEDS, PAUSED, SETTLED, octile

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]
Places = NDArray[np.int32]
State = tuple[Ints, Ints, Bytes, int, Ints, Ints, Ints, NDArray[np.float64], Places, Places, Ints]
"""What ``repair`` and ``amend`` take first."""

FAR = np.int64(1 << 60)
"""Not reached: more than any path costs, and sums with it do not wrap around."""

STATE_SIZE = 5
SIZE, COUNT, START, GOAL, MOVED = range(STATE_SIZE)
"""Of the field's state: cells in the heap, cells worked off, where the robot stands, where it goes, and the sum of the
estimates of its moves so far (k_m in the paper): keys made before are that much too low, which does no harm."""


@njit(cache=True, nogil=True, error_model="numpy")
def _follow(field: Ints, costs: Bytes, weights: Ints, offsets: Ints, cell: Int) -> Int:
    """Return the value of a cell that follows from those of its neighbours."""
    least = FAR
    open_sides = 0
    for move in range(8):
        if open_sides & NEEDS[move] != NEEDS[move]:
            continue
        beyond = field[cell + offsets[move]]
        if beyond == BLOCKED:
            continue
        if move < 4:
            open_sides |= 1 << move
        least = min(least, beyond + weights[move >> 2, costs[cell]])
    return least


@njit(cache=True, nogil=True, error_model="numpy")
def _queue(
    field: Ints, ahead: Ints, stride: Int, least: Ints,
    keys: NDArray[np.float64], cells: Places, places: Places, state: Ints, cell: Int,
) -> None:  # fmt: skip
    """Have a cell wait with its key if its two values differ, else not."""
    if field[cell] != ahead[cell]:
        value = min(field[cell], ahead[cell])
        total = value + octile(cell, state[START], stride, least[0], least[1]) + state[MOVED]
        state[SIZE] = put(keys, cells, places, state[SIZE], cell, float(total), float(value))
    elif places[cell] > 0:
        state[SIZE] = drop(keys, cells, places, state[SIZE], cell)


@njit(cache=True, nogil=True, error_model="numpy")
def repair(
    field: Ints, ahead: Ints, costs: Bytes, stride: int, weights: Ints, offsets: Ints, least: Ints,
    keys: NDArray[np.float64], cells: Places, places: Places, state: Ints, budget: int,
) -> int:  # fmt: skip
    """Work off up to ``budget`` cells and tell why it stopped.

    Parameters
    ----------
    field, ahead : (n,) int64 array
        Both values of each cell of the padded map.
    costs : (n,) uint8 array
    stride : int
        Elements in a row.
    weights : (2, 256) int64 array
        Of cardinal and of diagonal moves from a cell of each cost.
    offsets : (8,) int64 array
        From a cell to its neighbours, in the order that ``NEEDS`` counts on.
    least : (2,) int64 array
        Least weight of a cardinal and of a diagonal move.
    keys, cells, places
        The heap's: value, estimate and ``MOVED`` together, then the value; see `ppaas.planners.kernels.indexed_heap`.
    state : (STATE_SIZE,) int64 array
    budget : int

    Returns
    -------
    int
        SETTLED if both values of the start are final, EXHAUSTED if it has none, PAUSED.
    """
    start, goal = state[START], state[GOAL]
    for _ in range(budget):
        if state[SIZE] == 0:
            return SETTLED if field[start] < FAR else EXHAUSTED
        value = min(field[start], ahead[start])
        total = float(value + state[MOVED])
        if field[start] == ahead[start] and not (
            keys[1, 0] < total or (keys[1, 0] == total and keys[1, 1] < float(value))
        ):
            return SETTLED
        cell = np.int64(cells[1])
        value = min(field[cell], ahead[cell])
        total = float(value + octile(cell, start, stride, least[0], least[1]) + state[MOVED])
        if keys[1, 0] < total:  # its key was made before the robot moved on
            state[SIZE] = put(keys, cells, places, state[SIZE], cell, total, float(value))
            continue
        state[COUNT] += 1
        old = field[cell]
        lower = old > ahead[cell]
        field[cell] = ahead[cell] if lower else FAR
        _queue(field, ahead, stride, least, keys, cells, places, state, cell)
        open_sides = 0
        for move in range(8):
            if open_sides & NEEDS[move] != NEEDS[move]:
                continue
            neighbour = cell + offsets[move]
            if field[neighbour] == BLOCKED:
                continue
            if move < 4:
                open_sides |= 1 << move
            if neighbour == goal:
                continue
            weight = weights[move >> 2, costs[neighbour]]
            if lower:
                if field[cell] + weight >= ahead[neighbour]:
                    continue
                ahead[neighbour] = field[cell] + weight
            elif ahead[neighbour] == old + weight:
                ahead[neighbour] = _follow(field, costs, weights, offsets, neighbour)
            else:
                continue
            _queue(field, ahead, stride, least, keys, cells, places, state, neighbour)
    return PAUSED


@njit(cache=True, nogil=True, error_model="numpy")
def amend(
    field: Ints, ahead: Ints, costs: Bytes, stride: int, weights: Ints, offsets: Ints, least: Ints,
    keys: NDArray[np.float64], cells: Places, places: Places, state: Ints, changed: Ints, new_costs: Bytes,
) -> None:  # fmt: skip
    """Give cells other costs, and queue all that those concern.

    Parameters
    ----------
    field, ahead, costs, stride, weights, offsets, least, keys, cells, places, state
        As in ``repair``; weights are 0 for costs that block.
    changed : (m,) int64 array
        Cells of the padded map; the goal may change, but not become blocked.
    new_costs : (m,) uint8 array
    """
    for index in range(changed.size):
        cell, cost = changed[index], new_costs[index]
        was_open, is_open = field[cell] != BLOCKED, weights[0, cost] > 0
        costs[cell] = cost
        if was_open and not is_open:
            state[SIZE] = drop(keys, cells, places, state[SIZE], cell)
            field[cell], ahead[cell] = BLOCKED, FAR
        elif is_open and not was_open:
            field[cell] = FAR
        # A graded change concerns the cell alone, whose moves weigh something else now; others, its neighbours as well.
        for move in range(-1, 8 if was_open != is_open else 0):
            near = cell if move < 0 else cell + offsets[move]
            if field[near] == BLOCKED or near == state[GOAL]:
                continue
            ahead[near] = _follow(field, costs, weights, offsets, near)
            _queue(field, ahead, stride, least, keys, cells, places, state, near)


def warm() -> None:
    """Compile and call each kernel once."""
    field, ahead = np.full(9, BLOCKED, np.int64), np.full(9, FAR)
    field[4] = FAR
    ahead[4] = AT_GOAL
    fixed = (np.zeros(9, np.uint8), 3, np.ones((2, 256), np.int64), np.array([-1, 1, -3, 3, -4, -2, 2, 4]))
    heap = (np.zeros((11, 2)), np.zeros(11, np.int32), np.zeros(9, np.int32))
    state = np.array([0, 0, 4, 4, 0])
    everything = (field, ahead, *fixed, np.ones(2, np.int64), *heap, state)
    amend(*everything, np.array([4]), np.zeros(1, np.uint8))
    repair(*everything, 1)
