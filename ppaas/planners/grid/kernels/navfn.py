"""Kernel: grow a navigation function from its goal, as navfn does.

The potential of a cell is interpolated from the lower one of its left and right neighbours and the lower one of those
above and below, by a plane-wave approximation. If the two differ by at least the weight of the cell, only the lower one
counts. Queued cells are in three buffers: those of the current cycle, of the next one, and beyond a priority threshold,
which rises when the first two are empty. So cells are expanded approximately in the order of their potential, and again
if it falls.

The arrays are padded by a cell on each side, as in `ppaas.planners.field.kernels.layout`. Potentials are in single
precision, and infinite if not reached. Blocked cells are always marked as waiting, so that they are never queued.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

Int = int | np.signedinteger[Any]
Floats = NDArray[np.float32]
Bytes = NDArray[np.uint8]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]
Cells = NDArray[np.uint32]

EXHAUSTED, FOUND, PAUSED, FULL, TOO_FAR = range(5)
"""Reasons to stop: no queued cell is left; the target is reached; the budget is used up (call again); the buffers are
full (enlarge them and call again); potentials are too high for single precision."""

STATE_SIZE = 6
CURRENT, NEXT, BEYOND, COUNT, COUNT_BEYOND, REACHED = range(STATE_SIZE)
"""Elements of the state: rows of the buffers for the current cycle, the next one, and beyond the threshold; cells in
the first and in the last of these; number of reached cells."""

NEUTRAL = np.float32(50.0)
RISE = np.float32(100.0)
"""Increment of the threshold: twice the neutral cost."""

HIGHEST = np.float32(1 << 28)
"""Highest threshold: beyond it single precision cannot distinguish the potentials of adjacent cells."""

INVERSE_SQRT2 = np.float32(0.707106781)
"""A neighbour is queued if its potential exceeds that of the cell by more than this fraction of its weight."""

_1 = np.uint64(1)


@compiled
def _interpolate(across: np.float32, along: np.float32, weight: np.float32) -> np.float32:
    """Return the potential of a cell from those of two neighbours: navfn's quadratic approximation of a plane wave."""
    least, apart = min(across, along), abs(across - along)
    if apart >= weight:
        return least + weight
    part = apart / weight
    return least + weight * ((np.float32(-0.2301) * part + np.float32(0.5307)) * part + np.float32(0.7040))


@compiled
def expand(
    potentials: Floats, weights: Bytes, waiting: Flags, stride: int, buffers: Cells, state: Ints,
    threshold: Floats, target: int, pull: np.float32, budget: int,
) -> int:  # fmt: skip
    """Run whole cycles that expand about ``budget`` cells in total, and return why the kernel stopped.

    Parameters
    ----------
    potentials : (n,) float32 array
        Potentials: 0 at the goal, infinite if not reached. In and out.
    weights : (n,) uint8 array
        Weight of crossing each cell.
    waiting : (n,) bool array
        Whether a cell is in a buffer, or blocked. In and out.
    stride : int
        Number of elements in a row.
    buffers : (3, capacity) uint32 array
        Cells of the current cycle, of the next one, and beyond the threshold, in the rows given by ``state``. In and
        out.
    state : (STATE_SIZE,) int64 array
        In and out.
    threshold : (1,) float32 array
        Priority from which the neighbours of a cell are deferred. In and out.
    target : int
        Cell to reach; −1 to reach all.
    pull : float32
        Weight of the straight distance to the target in the priority; 0 for Dijkstra's order.
    budget : int
        Number of cells to expand before it pauses.

    Returns
    -------
    int
        EXHAUSTED, FOUND, PAUSED, FULL or TOO_FAR.
    """
    target_row, target_column = target // stride, target % stride
    row_length = np.uint64(stride)
    done = 0
    while True:
        count, current = state[COUNT], state[CURRENT]
        if target >= 0 and potentials[target] < np.inf:
            return FOUND
        if count == 0:
            return EXHAUSTED
        if done >= budget:
            return PAUSED
        if 4 * count + state[COUNT_BEYOND] > buffers.shape[1]:
            return FULL
        limit = threshold[0]
        if limit > HIGHEST:
            return TOO_FAR
        # One cycle: expand all cells of the current buffer.
        for entry in range(count):
            waiting[buffers[current, entry]] = False
        following, beyond = state[NEXT], state[BEYOND]
        count_next, count_beyond, reached = 0, state[COUNT_BEYOND], 0
        for entry in range(count):
            # Unsigned indices, as in `bits`: without the check for negative ones.
            cell = np.uint64(buffers[current, entry])
            left, right = potentials[cell - _1], potentials[cell + _1]
            below, above = potentials[cell - row_length], potentials[cell + row_length]
            potential = _interpolate(min(left, right), min(below, above), np.float32(weights[cell]))
            if not potential < potentials[cell]:
                continue
            reached += potentials[cell] == np.inf
            potentials[cell] = potential
            key = potential
            if pull > 0.0:
                row = np.int64(cell) // stride
                up, over = np.float32(row - target_row), np.float32(np.int64(cell) - row * stride - target_column)
                key += pull * np.sqrt(up * up + over * over)
            late = key >= limit
            into = beyond if late else following
            at = count_beyond if late else count_next
            around = ((cell - _1, left), (cell + _1, right), (cell - row_length, below), (cell + row_length, above))
            for neighbour, value in around:
                if value > potential + INVERSE_SQRT2 * np.float32(weights[neighbour]) and not waiting[neighbour]:
                    buffers[into, at] = neighbour
                    waiting[neighbour] = True
                    at += 1
            if late:
                count_beyond = at
            else:
                count_next = at
        # Swap the buffers; if the next one is empty, raise the threshold and continue with the deferred cells.
        done += count
        state[REACHED] += reached
        state[CURRENT], state[NEXT], state[COUNT], state[COUNT_BEYOND] = following, current, count_next, count_beyond
        if count_next == 0:
            threshold[0] += RISE
            state[CURRENT], state[BEYOND] = beyond, following
            state[COUNT], state[COUNT_BEYOND] = count_beyond, 0


def warm() -> None:
    """Compile and call the kernel once."""
    potentials = np.full(9, np.inf, np.float32)
    potentials[3] = 0.0
    waiting = np.ones(9, np.bool_)
    waiting[4] = False
    buffers, state = np.full((3, 4), 4, np.uint32), np.array([0, 1, 2, 1, 0, 0])
    threshold = np.zeros(1, np.float32)
    expand(potentials, np.full(9, 50, np.uint8), waiting, 3, buffers, state, threshold, -1, np.float32(0.0), 9)
