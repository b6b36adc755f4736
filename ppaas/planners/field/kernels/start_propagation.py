"""Kernel: grow a field of costs outward from a start, where a move weighs what the cell weighs that it leaves.

A cell waits in one list from when it is reached until its value is final. In each round the cells are taken whose value
is less than the lowest plus the least weight: no move can lower one of them any more (Dial's buckets, 1969, as in
propagation, with one bucket at a time).
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.planners.kernels.moves import NEEDS

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]

BLOCKED = -1.0

EXHAUSTED, FOUND, PAUSED, FULL = range(4)
"""Why it stopped: no cell is left; all targets have their final values; the slice is used up; the list needs more room,
and both of these want another call."""

STATE_SIZE = 2
WAITING, TARGET = range(STATE_SIZE)
"""Of the search's state: cells in the list; targets that are done."""

SQRT2 = 1.4142135623730951


@njit(cache=True, nogil=True, error_model="numpy")
def leave(
    values: NDArray[np.float64], costs: NDArray[np.uint8], stride: int, weights: NDArray[np.float64], least: float,
    waiting: NDArray[np.uint32], state: Ints, targets: Ints, budget: int,
) -> int:  # fmt: skip
    """Work off whole rounds of about ``budget`` cells in all and tell why it stopped.

    Parameters
    ----------
    values : (n,) float64 array
        0 at the start, infinite where not reached, ``BLOCKED``; padded by a blocked cell on each side.
    costs : (n,) uint8 array
        Costs of the cells.
    stride : int
        Elements in a row.
    weights : (256,) float64 array
        What leaving a cell of each cost weighs.
    least : float
        Of these, the least.
    waiting : (capacity,) uint32 array
        The list.
    state : (STATE_SIZE,) int64 array
    targets : (m,) int64 array
        Cells whose values are wanted.
    budget : int
        Cells to work off before it pauses.

    Returns
    -------
    int
        EXHAUSTED, FOUND, PAUSED or FULL.
    """
    offsets = (-1, 1, -stride, stride, -stride - 1, -stride + 1, stride - 1, stride + 1)
    done = 0
    while state[WAITING] > 0:
        lowest = np.inf
        for place in range(state[WAITING]):
            lowest = min(lowest, values[waiting[place]])
        while state[TARGET] < targets.size and 0.0 <= values[targets[state[TARGET]]] <= lowest:
            state[TARGET] += 1
        if state[TARGET] == targets.size:
            return FOUND
        if done >= budget:
            return PAUSED
        if 9 * state[WAITING] > waiting.size:
            return FULL
        # The cells of this round go to the end of the list, and those that they reach behind them.
        place, first, behind = 0, state[WAITING], state[WAITING]
        while place < first:
            here = waiting[place]
            if values[here] < lowest + least:
                first -= 1
                waiting[place], waiting[first] = waiting[first], here
            else:
                place += 1
        last = behind
        for place in range(first, behind):
            cell = np.int64(waiting[place])
            value, weight = values[cell], weights[costs[cell]]
            open_sides = 0
            for move in range(8):
                if open_sides & NEEDS[move] != NEEDS[move]:
                    continue
                neighbour = cell + offsets[move]
                old = values[neighbour]
                if old >= 0.0 and move < 4:
                    open_sides |= 1 << move
                new = value + (weight if move < 4 else weight * SQRT2)
                if new < old:
                    values[neighbour] = new
                    if old == np.inf:
                        waiting[last] = neighbour
                        last += 1
        done += behind - first
        for place in range(last - behind):
            waiting[first + place] = waiting[behind + place]
        state[WAITING] = first + last - behind
    return EXHAUSTED


def warm() -> None:
    """Compile and call the kernel once."""
    values = np.full(12, BLOCKED)
    values[5], values[6] = 0.0, np.inf
    waiting, state = np.full(64, 5, np.uint32), np.array([1, 0])
    leave(values, np.zeros(12, np.uint8), 4, np.ones(256), 1.0, waiting, state, np.array([6]), 9)
