"""Kernel: search for a path of straight lines between cells of any distance: Lazy Theta*.

Sources: Daniel, Nash, Koenig and Felner, "Theta*: Any-Angle Path Planning on Grids", 2010; Nash, Koenig and Tovey,
"Lazy Theta*: Any-Angle Path Planning and Path Length Analysis in 3D", 2010. A cell is guessed to be reached straight
from the parent of the cell that found it; whether it is, and what that costs, is looked up only when the cell is first
in the queue. Four things differ:

- What is left to the target is estimated from a field of costs-to-go in moves from cell to cell. That is up to 8 % more
  than straight lines cost, so most of it is counted: the fewer cells are worked off.
- Lines over cells of several costs are guessed to be as dear for each unit of length as the two lines they cut short.
- A cell whose guess was too good goes back into the queue with what it truly costs.
- A cell that was worked off is worked off again where one of its neighbours gives it a lower cost.

By the last two a cell costs no more than by any moves over cells that were worked off. On the cheapest path in moves
the estimate is never more than is left in moves; so, as in A*, the target is not reached before that path could be
taken: where all cells weigh the same, no path in moves is shorter than the one found.
"""

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.planners.grid.kernels.line_of_sight import HAIR, HIDDEN, weigh
from ppaas.planners.kernels.indexed_heap import drop, put
from ppaas.planners.kernels.moves import EXHAUSTED, NEEDS, PAUSED, SETTLED
from ppaas.planners.weights import SCALE

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]

UNSEEN, GUESSED, KNOWN, DONE = range(4)
"""What is known of a cell: nothing, a cost that may be too low, a cost, and that it was worked off."""

SPAN = 128
"""To weigh a line of as many cells takes about as long as to work off one."""

STATE_SIZE = 2
SIZE, COUNT = range(STATE_SIZE)
"""Of the search's state: cells in the heap, cells worked off."""

LEAN = 0.95
"""The part of the costs-to-go that is counted: 0.924 would never be too much, 1 keeps to the cheapest path in moves. Of
this much, paths are 0.1 % longer than of 0.924, and a third of the cells are worked off."""

SQRT2 = math.sqrt(2.0)


@njit(cache=True, nogil=True, error_model="numpy")
def _place(cell: Int, stride: Int) -> tuple[Int, Int]:
    """Return row and column of a cell on the padded map; unsigned and short, which is the fastest division there is."""
    row = np.int64(np.uint32(cell) // np.uint32(stride))
    return row, cell - row * stride


@njit(cache=True, nogil=True, error_model="numpy")
def _distance(down: Int, right: Int) -> float:
    return math.sqrt(down * down + right * right)


@njit(cache=True, nogil=True, error_model="numpy")
def _reveal(
    costs: Bytes, stride: Int, weights: Ints, offsets: Ints, value: NDArray[np.float64], parent: NDArray[np.int32],
    status: Bytes, cell: Int,
) -> int:  # fmt: skip
    """Give a guessed cell the least that it costs from its parent or from a neighbour that was worked off.

    Returns how many rows and columns the line to its parent leads over.
    """
    begin = np.int64(parent[cell])
    down, right = cell // stride - begin // stride, cell % stride - begin % stride
    best, best_parent = np.inf, begin
    line = weigh(costs, stride, weights, begin, down, right)
    if line != HIDDEN:
        best = value[begin] + line
    weight = weights[costs[cell]]
    open_sides = 0
    for move in range(8):
        if open_sides & NEEDS[move] != NEEDS[move]:
            continue
        neighbour = cell + offsets[move]
        entered = weights[costs[neighbour]]
        if entered == 0:
            continue
        if move < 4:
            open_sides |= 1 << move
        if status[neighbour] != DONE:
            continue
        length = 1.0 if move < 4 else SQRT2
        reached = value[neighbour] + 0.5 * (weight + entered) * length
        if reached < best * (1.0 - HAIR):
            best, best_parent = reached, neighbour
    value[cell], parent[cell], status[cell] = best, best_parent, KNOWN
    return int(abs(down) + abs(right))


@njit(cache=True, nogil=True, error_model="numpy")
def find(
    costs: Bytes, stride: int, weights: Ints, offsets: Ints, least: float, toward: NDArray[np.float64], most: float,
    value: NDArray[np.float64], parent: NDArray[np.int32], status: Bytes,
    keys: NDArray[np.float64], cells: NDArray[np.int32], places: NDArray[np.int32], state: Ints,
    target: int, budget: int,
) -> int:  # fmt: skip
    """Work off up to ``budget`` cells and tell why it stopped.

    Parameters
    ----------
    costs, stride, weights
        As in `ppaas.planners.grid.kernels.line_of_sight.weigh`.
    offsets : (8,) int64 array
        From a cell to its neighbours, the four cardinal ones first, in the order that ``NEEDS`` counts on.
    least : float
        Least weight of any cell.
    toward : (height, width) float64 array
        Costs-to-go in moves, of the map without its margin, in whole weights.
    most : float
        Cells from which more is left than this are not looked at.
    value : (n,) float64 array
        What each cell costs that is seen.
    parent : (n,) int32 array
        The cell from which it is reached in a straight line; itself at the start.
    status : (n,) uint8 array
        UNSEEN, GUESSED, KNOWN or DONE.
    keys, cells, places
        The heap's: cost and estimate together, then the estimate; see `ppaas.planners.kernels.indexed_heap`.
    state : (STATE_SIZE,) int64 array
    target : int
        Cell to reach.
    budget : int
        Cells to take from the heap before it pauses; `SPAN` cells on a line count as one more.

    Returns
    -------
    int
        EXHAUSTED, SETTLED or PAUSED.
    """
    lean = LEAN * SCALE
    target_row, target_column = _place(target, stride)
    while budget > 0:
        budget -= 1
        if state[SIZE] == 0:
            return EXHAUSTED
        cell = np.int64(cells[1])
        if status[cell] == GUESSED:
            guess = value[cell]
            budget -= _reveal(costs, stride, weights, offsets, value, parent, status, cell) // SPAN
            if value[cell] > guess * (1.0 + HAIR):
                row, column = _place(cell, stride)
                straight = _distance(target_row - row, target_column - column)
                ahead = max(least * straight, lean * toward[row - 1, column - 1])
                put(keys, cells, places, state[SIZE], cell, value[cell] + ahead, ahead)
                continue
        if cell == target:
            return SETTLED
        state[SIZE] = drop(keys, cells, places, state[SIZE], cell)
        state[COUNT] += 1
        status[cell] = DONE
        begin = np.int64(parent[cell])
        begin_row, begin_column = _place(begin, stride)
        row, column = _place(cell, stride)
        before, so_far = _distance(row - begin_row, column - begin_column), value[cell] - value[begin]
        open_sides = 0
        for move in range(8):
            if open_sides & NEEDS[move] != NEEDS[move]:
                continue
            neighbour = cell + offsets[move]
            entered = weights[costs[neighbour]]
            if entered == 0:
                continue
            if move < 4:
                open_sides |= 1 << move
            row, column = _place(neighbour, stride)
            if toward[row - 1, column - 1] > most:
                continue
            length = 1.0 if move < 4 else SQRT2
            step = 0.5 * (weights[costs[cell]] + entered) * length
            if status[neighbour] >= KNOWN:
                if value[cell] + step >= value[neighbour] * (1.0 - HAIR):
                    continue
                value[neighbour], parent[neighbour], status[neighbour] = value[cell] + step, cell, KNOWN
            else:
                whole = _distance(row - begin_row, column - begin_column)
                guess = value[begin] + (so_far + step) * (whole / (before + length))
                if status[neighbour] == GUESSED and guess >= value[neighbour] * (1.0 - HAIR):
                    continue
                value[neighbour], parent[neighbour], status[neighbour] = guess, begin, GUESSED
            straight = _distance(target_row - row, target_column - column)
            ahead = max(least * straight, lean * toward[row - 1, column - 1])
            state[SIZE] = put(keys, cells, places, state[SIZE], neighbour, value[neighbour] + ahead, ahead)
    return PAUSED


def warm() -> None:
    """Compile and call each kernel once."""
    offsets = np.array([-1, 1, -3, 3, -4, -2, 2, 4])
    costs, places = np.full(9, 254, np.uint8), np.zeros(9, np.int32)
    costs[4], places[4] = 0, 1
    find(
        costs, 3, np.ones(256, np.int64), offsets, 1.0, np.zeros((1, 1)), 0.0,
        np.zeros(9), np.full(9, 4, np.int32), np.full(9, KNOWN, np.uint8),
        np.zeros((10, 2)), np.full(10, 4, np.int32), places, np.array([1, 0]), 0, 2,
    )  # fmt: skip
