"""Kernel: grow a navigation function from its goal, as navfn does.

The potential of a cell is interpolated from the lower of its neighbours left and right and the lower of those above and
below, as if a plane wave came from both; one that is not lower by the cell's whole weight than the other counts. Cells
to work off are in three buffers: those of this cycle, those of the next one, and those beyond the threshold, which
rises when the first two are empty. So cells come roughly by their potential, and are worked off again where it falls.

The arrays are padded by a cell on each side, as in `ppaas.planners.field.kernels.layout`. Potentials are single
precision and infinite where not reached; a cell that must not be entered is marked as waiting for ever, so that it
never is put in.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Int = int | np.signedinteger[Any]
Floats = NDArray[np.float32]
Bytes = NDArray[np.uint8]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]
Cells = NDArray[np.uint32]

EXHAUSTED, FOUND, PAUSED, FULL, TOO_FAR = range(5)
"""Why it stopped: no cell is left; the target is reached; the slice is used up; the buffers need more room, and both of
these want another call; potentials are too high for single precision."""

STATE_SIZE = 6
CURRENT, NEXT, BEYOND, COUNT, COUNT_BEYOND, REACHED = range(STATE_SIZE)
"""Of the search's state: which rows of the buffers are whose, cells in the first and in the last, cells reached."""

NEUTRAL = np.float32(50.0)
RISE = np.float32(100.0)
"""By which the threshold rises: twice the neutral cost."""

HIGHEST = np.float32(1 << 28)
"""Beyond this threshold single precision is too coarse to tell one cell's potential from the next one's."""

INVERSE_SQRT2 = np.float32(0.707106781)
"""No cell's potential falls for a neighbour's that is not lower by this part of its weight."""

_1 = np.uint64(1)


@njit(cache=True, nogil=True, error_model="numpy")
def _interpolate(across: np.float32, along: np.float32, weight: np.float32) -> np.float32:
    """Return the potential of a cell between two neighbours, by a quadratic approximation of the plane wave's."""
    least, apart = min(across, along), abs(across - along)
    if apart >= weight:
        return least + weight
    part = apart / weight
    return least + weight * ((np.float32(-0.2301) * part + np.float32(0.5307)) * part + np.float32(0.7040))


@njit(cache=True, nogil=True, error_model="numpy")
def expand(
    potentials: Floats, weights: Bytes, waiting: Flags, stride: int, buffers: Cells, state: Ints,
    threshold: Floats, target: int, pull: np.float32, budget: int,
) -> int:  # fmt: skip
    """Work off whole cycles of about ``budget`` cells in all, and tell why it stopped.

    Parameters
    ----------
    potentials : (n,) float32 array
        Infinite where not reached, 0 at the goal.
    weights : (n,) uint8 array
        What it costs to cross each cell.
    waiting : (n,) bool array
        Whether a cell is in a buffer, or blocked.
    stride : int
        Elements in a row.
    buffers : (3, capacity) uint32 array
        Cells of this cycle, of the next, and beyond the threshold, in the rows that ``state`` names.
    state : (STATE_SIZE,) int64 array
    threshold : (1,) float32 array
        Potential from which on a cell's neighbours are put off.
    target : int
        Cell that is to be reached; −1 to go on until all are.
    pull : float32
        What the straight distance from the target counts beside the potential; 0 for Dijkstra's order.
    budget : int
        Cells to work off before it pauses.

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
        for entry in range(count):
            waiting[buffers[current, entry]] = False
        following, beyond = state[NEXT], state[BEYOND]
        count_next, count_beyond, reached = 0, state[COUNT_BEYOND], 0
        for entry in range(count):
            # Unsigned, as in pose_text: no index counts from the end.
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
