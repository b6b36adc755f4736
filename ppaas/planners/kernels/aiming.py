"""Kernel: grow a field of costs from its goal towards one cell: A* (Hart, Nilsson and Raphael, 1968).

What is left from a cell to the target is estimated by the octile distance at the least weights there are. No move
lowers value and estimate together (the estimate is consistent, in fixed point as well: a diagonal is rounded the same
way in both), so a cell that is taken from the queue has its final value and is worked off once. The queue is a binary
heap with lazy deletion: a cell whose value fell is put in again, and what was put in before is skipped.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.planners.kernels.layout import AT_GOAL, UNREACHED, UNREACHED_WIDE
from ppaas.planners.kernels.propagation import EXHAUSTED, NEEDS, PAUSED, POOL_EMPTY, SETTLED, TOO_NARROW

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]
Pool = NDArray[np.uint32]
Field = NDArray[np.uint32] | NDArray[np.int64]

STATE_SIZE = 2
SIZE, COUNT = range(STATE_SIZE)
"""Of the search's state: entries in the heap, cells worked off."""

LONGEST_MOVE = 1 << 15
"""No move weighs as much: the longest weighs 30 413."""

TIE_BITS, TIE_SHIFT = 18, 10
"""The lowest bits of a key are the estimate, coarsely: of equal sums the cell nearer to the target goes first. The rest
holds any sum: 2³⁰ moves of the longest are less than 2⁴⁵."""


@njit(cache=True, nogil=True, error_model="numpy")
def estimate(cell: Int, target: Int, stride: Int, cardinal: Int, diagonal: Int) -> int:
    """Return the least that any path between two cells can weigh."""
    # Unsigned and short: the fastest division there is.
    across = np.uint32(stride)
    row, target_row = np.uint32(cell) // across, np.uint32(target) // across
    down = abs(np.int64(row) - np.int64(target_row))
    right = abs((cell - np.int64(row) * stride) - (target - np.int64(target_row) * stride))
    return int(min(down, right) * diagonal + abs(down - right) * cardinal)


@njit(cache=True, nogil=True, error_model="numpy")
def _push(keys: Ints, cells: Pool, size: Int, key: Int, cell: Int) -> None:
    at = size
    while at > 0:
        above = (at - 1) >> 1
        if keys[above] <= key:
            break
        keys[at] = keys[above]
        cells[at] = cells[above]
        at = above
    keys[at] = key
    cells[at] = cell


@njit(cache=True, nogil=True, error_model="numpy")
def _drop_first(keys: Ints, cells: Pool, size: Int) -> None:
    last_key, last_cell = keys[size - 1], cells[size - 1]
    at, below = 0, 1
    while below < size - 1:
        if below + 1 < size - 1 and keys[below + 1] < keys[below]:
            below += 1
        if last_key <= keys[below]:
            break
        keys[at] = keys[below]
        cells[at] = cells[below]
        at, below = below, 2 * below + 1
    keys[at] = last_key
    cells[at] = last_cell


@njit(cache=True, nogil=True, error_model="numpy")
def aim(
    field: Field, costs: NDArray[np.uint8], stride: int, weights: Ints, least: Ints,
    keys: Ints, cells: Pool, state: Ints, target: int, limit: int, budget: int,
) -> int:  # fmt: skip
    """Work off up to ``budget`` cells and tell why it stopped.

    Parameters
    ----------
    field, costs, stride, weights
        As in `ppaas.planners.kernels.propagation`.
    least : (2,) int64 array
        Least weight of a cardinal and of a diagonal move.
    keys : (capacity,) int64 array
        The heap's: value and estimate together, then the estimate alone.
    cells : (capacity,) uint32 array
        The heap's cells.
    state : (STATE_SIZE,) int64 array
    target : int
        Cell whose value is wanted.
    limit : int
        Most that a value may be.
    budget : int
        Cells to work off before it pauses.

    Returns
    -------
    int
        EXHAUSTED, SETTLED, PAUSED, POOL_EMPTY (enlarge the heap) or TOO_NARROW, as in propagation.
    """
    offsets = (-1, 1, -stride, stride, -stride - 1, -stride + 1, stride - 1, stride + 1)
    most_tie = (1 << TIE_BITS) - 1
    end = state[COUNT] + budget
    while state[SIZE] > 0:
        cell = np.int64(cells[0])
        value = np.int64(field[cell])
        left = estimate(cell, target, stride, least[0], least[1])
        stale = keys[0] >> TIE_BITS > value + left
        if not stale:
            if cell == target:
                return SETTLED
            if state[COUNT] >= end:
                return PAUSED
            if state[SIZE] + 8 > keys.size:
                return POOL_EMPTY
            if value > limit - LONGEST_MOVE:
                return TOO_NARROW
        _drop_first(keys, cells, state[SIZE])
        state[SIZE] -= 1
        if stale:
            continue
        state[COUNT] += 1
        open_sides = 0
        for move in range(8):
            if open_sides & NEEDS[move] != NEEDS[move]:
                continue
            neighbour = cell + offsets[move]
            old = np.int64(field[neighbour])
            if old > 0 and move < 4:
                open_sides |= 1 << move
            if old <= value:
                continue
            new = value + weights[move >> 2, costs[neighbour]]
            if new >= old:
                continue
            field[neighbour] = new
            ahead = estimate(neighbour, target, stride, least[0], least[1])
            key = ((new + ahead) << TIE_BITS) | min(ahead >> TIE_SHIFT, most_tie)
            _push(keys, cells, state[SIZE], key, neighbour)
            state[SIZE] += 1
    return EXHAUSTED


def warm() -> None:
    """Compile and call each kernel once, for narrow and for wide fields."""
    weights, least = np.ones((2, 256), np.int64), np.ones(2, np.int64)
    narrow, wide = np.zeros(12, np.uint32), np.zeros(12, np.int64)
    narrow[6], wide[6] = UNREACHED, UNREACHED_WIDE
    for field in (narrow, wide):
        field[5] = AT_GOAL
        keys, cells, state = np.zeros(16, np.int64), np.full(16, 5, np.uint32), np.array([1, 0])
        aim(field, np.zeros(12, np.uint8), 4, weights, least, keys, cells, state, 6, 1 << 31, 9)
