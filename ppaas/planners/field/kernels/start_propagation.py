"""Kernel: grow a cost field outward from a start, where a move weighs as much as the cell that it leaves.

Open cells are in one list from when they are reached until their value is final. Each round expands all cells whose
value is below the lowest one plus the least weight: no move can lower those any more. That is Dial's algorithm (1969)
as in ``propagation``, with a single bucket.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.planners.kernels.moves import NEEDS

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]

BLOCKED = -1.0

EXHAUSTED, FOUND, PAUSED, FULL = range(4)
"""Reasons to stop: no open cell is left; the values of all targets are final; the budget is used up; the list is full.
After the last two, call again (with a larger list)."""

STATE_SIZE = 2
WAITING, TARGET = range(STATE_SIZE)
"""Elements of the search's state: number of open cells; number of targets with final values."""

SQRT2 = 1.4142135623730951


@compiled
def grow_from_start(
    values: NDArray[np.float64], costs: NDArray[np.uint8], stride: int, weights: NDArray[np.float64], least: float,
    waiting: NDArray[np.uint32], state: Ints, targets: Ints, budget: int,
) -> int:  # fmt: skip
    """Run whole rounds that expand about ``budget`` cells in total, and return why the kernel stopped.

    Parameters
    ----------
    values : (n,) float64 array
        Cost from the start: 0 at the start, infinite if not reached, `BLOCKED`; padded by a blocked cell on each side.
        In and out.
    costs : (n,) uint8 array
        Costs of the cells.
    stride : int
        Number of elements in a row.
    weights : (256,) float64 array
        Weight of leaving a cell of each cost.
    least : float
        The least of them.
    waiting : (capacity,) uint32 array
        The list of open cells. In and out.
    state : (STATE_SIZE,) int64 array
    targets : (m,) int64 array
        Cells whose values are wanted.
    budget : int
        Number of cells to expand before it pauses.

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
        # Partition the list: the cells of this round move to its end; cells that they reach are appended behind them.
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
        # Remove the expanded cells: move the appended ones to their place.
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
    grow_from_start(values, np.zeros(12, np.uint8), 4, np.ones(256), 1.0, waiting, state, np.array([6]), 9)
