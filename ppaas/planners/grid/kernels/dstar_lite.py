"""Kernels of D* Lite: repair a cost field when the map changes and the robot moves.

Source: Koenig and Likhachev, "D* Lite", 2002, optimized version (figure 4). Each cell has two values: the one that it
had when it was last expanded (g in the paper, ``field`` here), and the one that follows from its neighbours (rhs,
``ahead`` here). Inconsistent cells, whose two values differ, are in a heap; its keys put those first that may affect
the robot's path. Only these are expanded; cells that a change does not affect are not touched.

Both values are costs-to-go in fixed point plus ``AT_GOAL``, as in `ppaas.planners.field.kernels.layout`. No move enters
a blocked cell or passes its corner, so a cell that becomes blocked is removed at once: it affects only its neighbours.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.planners.field.kernels.layout import AT_GOAL, BLOCKED
from ppaas.planners.kernels.indexed_heap import drop, put
from ppaas.planners.kernels.moves import EXHAUSTED, NEEDS, PAUSED, SETTLED, octile

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]
Places = NDArray[np.int32]
State = tuple[Ints, Ints, Bytes, int, Ints, Ints, Ints, NDArray[np.float64], Places, Places, Ints]
"""Types of the leading arguments of ``repair`` and ``amend``."""

FAR = np.int64(1 << 60)
"""Value of unreached cells (infinity in the paper): more than any path costs, and sums with it do not overflow."""

STATE_SIZE = 5
SIZE, COUNT, START, GOAL, MOVED = range(STATE_SIZE)
"""Elements of the state: cells in the heap, expansions, the robot's cell, the goal, and the sum of the heuristics of
the robot's moves so far (k_m in the paper), by which earlier keys are too low; the algorithm allows for that."""


@compiled
def _rhs(field: Ints, costs: Bytes, weights: Ints, offsets: Ints, cell: Int) -> Int:
    """Return the rhs of a cell: the minimum over its neighbours of their value plus the weight of the move."""
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


@compiled
def _queue(
    field: Ints, ahead: Ints, stride: Int, least: Ints,
    keys: NDArray[np.float64], cells: Places, places: Places, state: Ints, cell: Int,
) -> None:  # fmt: skip
    """Insert a cell with its key if it is inconsistent, or update its key; else remove it (UpdateVertex)."""
    if field[cell] != ahead[cell]:
        value = min(field[cell], ahead[cell])
        total = value + octile(cell, state[START], stride, least[0], least[1]) + state[MOVED]
        state[SIZE] = put(keys, cells, places, state[SIZE], cell, float(total), float(value))
    elif places[cell] > 0:
        state[SIZE] = drop(keys, cells, places, state[SIZE], cell)


@compiled
def repair(
    field: Ints, ahead: Ints, costs: Bytes, stride: int, weights: Ints, offsets: Ints, least: Ints,
    keys: NDArray[np.float64], cells: Places, places: Places, state: Ints, budget: int,
) -> int:  # fmt: skip
    """Expand up to ``budget`` cells (ComputeShortestPath) and return why the kernel stopped.

    Parameters
    ----------
    field, ahead : (n,) int64 array
        g and rhs of each cell of the padded map. In and out.
    costs : (n,) uint8 array
        Costs of the cells.
    stride : int
        Number of elements in a row.
    weights : (2, 256) int64 array
        Weights of cardinal and diagonal moves from a cell of each cost; 0 for blocked costs.
    offsets : (8,) int64 array
        Offsets of the neighbours of a cell, in the order of ``NEEDS``.
    least : (2,) int64 array
        Least weight of a cardinal and of a diagonal move, for the heuristic.
    keys, cells, places
        The heap, as in `ppaas.planners.kernels.indexed_heap`. Keys: min(g, rhs) + heuristic + k_m, then min(g, rhs).
    state : (STATE_SIZE,) int64 array
        In and out.
    budget : int
        Maximum number of heap operations in this call.

    Returns
    -------
    int
        SETTLED if g and rhs of the robot's cell are final, EXHAUSTED if there is no path from it, or PAUSED.
    """
    start, goal = state[START], state[GOAL]
    for _ in range(budget):
        if state[SIZE] == 0:
            return SETTLED if field[start] < FAR else EXHAUSTED
        # The robot's cell is final if it is consistent and no key in the heap is lower than its own.
        value = min(field[start], ahead[start])
        total = float(value + state[MOVED])
        if field[start] == ahead[start] and not (
            keys[1, 0] < total or (keys[1, 0] == total and keys[1, 1] < float(value))
        ):
            return SETTLED
        cell = np.int64(cells[1])
        value = min(field[cell], ahead[cell])
        total = float(value + octile(cell, start, stride, least[0], least[1]) + state[MOVED])
        if keys[1, 0] < total:  # the key is outdated: the robot has moved since
            state[SIZE] = put(keys, cells, places, state[SIZE], cell, total, float(value))
            continue
        # Expand: an overconsistent cell takes its rhs; an underconsistent one becomes unreached first.
        state[COUNT] += 1
        old = field[cell]
        lower = old > ahead[cell]
        field[cell] = ahead[cell] if lower else FAR
        _queue(field, ahead, stride, least, keys, cells, places, state, cell)
        # Update the rhs of its neighbours.
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
                ahead[neighbour] = _rhs(field, costs, weights, offsets, neighbour)
            else:
                continue
            _queue(field, ahead, stride, least, keys, cells, places, state, neighbour)
    return PAUSED


@compiled
def amend(
    field: Ints, ahead: Ints, costs: Bytes, stride: int, weights: Ints, offsets: Ints, least: Ints,
    keys: NDArray[np.float64], cells: Places, places: Places, state: Ints, changed: Ints, new_costs: Bytes,
) -> None:  # fmt: skip
    """Change the costs of cells, and queue all cells that become inconsistent.

    Parameters
    ----------
    field, ahead, costs, stride, weights, offsets, least, keys, cells, places, state
        As in ``repair``.
    changed : (m,) int64 array
        Changed cells of the padded map; the goal must not become blocked.
    new_costs : (m,) uint8 array
        Their new costs.
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
        # A cell that stays free only affects its own rhs. One that becomes free or blocked also affects its neighbours.
        for move in range(-1, 8 if was_open != is_open else 0):
            near = cell if move < 0 else cell + offsets[move]
            if field[near] == BLOCKED or near == state[GOAL]:
                continue
            ahead[near] = _rhs(field, costs, weights, offsets, near)
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
