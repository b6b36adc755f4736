"""Kernel: Lazy Theta*, the search for a path of straight lines between cells.

Sources: Daniel, Nash, Koenig and Felner, "Theta*: Any-Angle Path Planning on Grids", 2010; Nash, Koenig and Tovey,
"Lazy Theta*: Any-Angle Path Planning and Path Length Analysis in 3D", 2010. A cell is assumed to be reached by a
straight line from the parent of the cell that found it; line of sight and cost are only checked when the cell is
popped. Four things differ from the papers:

- The heuristic is the cost field of moves from cell to cell. It is up to 8 % higher than the cost of straight lines, so
  it is multiplied by `LEAN`: the higher the factor, the fewer cells are expanded.
- The cost per length of a line over cells of several costs is assumed to be that of the two lines that it replaces.
- A cell whose assumed cost was too low is queued again with its true cost.
- An expanded cell is expanded again if one of its neighbours gives it a lower cost.

By the last two, no cell costs more than by moves over expanded cells. On the cheapest path of moves the heuristic never
exceeds the remaining cost of moves. Therefore, as in A*, the target is not expanded before that path has been
considered: on maps of one cost, no path of moves is shorter than the one found.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.planners.grid.kernels.line_of_sight import HAIR, HIDDEN, weigh
from ppaas.planners.kernels.indexed_heap import drop, put
from ppaas.planners.kernels.moves import EXHAUSTED, NEEDS, PAUSED, SETTLED
from ppaas.planners.weights import SCALE

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]

UNSEEN, GUESSED, KNOWN, DONE = range(4)
"""Status of a cell: not seen; assumed cost, which may be too low; true cost; expanded."""

SPAN = 128
"""Number of cells of a line whose check takes as long as an expansion."""

STATE_SIZE = 2
SIZE, COUNT = range(STATE_SIZE)
"""Elements of the state: cells in the heap, expansions."""

LEAN = 0.95
"""Factor on the cost field as the heuristic. 0.924 is admissible; 1 makes the search follow the cheapest path of moves.
With 0.95, paths are 0.1 % longer than with 0.924, and a third as many cells are expanded."""

SQRT2 = math.sqrt(2.0)


@compiled
def _place(cell: Int, stride: Int) -> tuple[Int, Int]:
    """Return row and column of a cell on the padded map; 32-bit unsigned division is the fastest."""
    row = np.int64(np.uint32(cell) // np.uint32(stride))
    return row, cell - row * stride


@compiled
def _distance(down: Int, right: Int) -> float:
    return math.sqrt(down * down + right * right)


@compiled
def _reveal(
    costs: Bytes, stride: Int, weights: Ints, offsets: Ints, value: NDArray[np.float64], parent: NDArray[np.int32],
    status: Bytes, cell: Int,
) -> int:  # fmt: skip
    """Replace the assumed cost of a cell by the true one: from its parent, if visible, or from an expanded neighbour.

    Returns the number of rows plus columns of the line to its parent.
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


@compiled
def find(
    costs: Bytes, stride: int, weights: Ints, offsets: Ints, least: float, toward: NDArray[np.float64], most: float,
    value: NDArray[np.float64], parent: NDArray[np.int32], status: Bytes,
    keys: NDArray[np.float64], cells: NDArray[np.int32], places: NDArray[np.int32], state: Ints,
    target: int, budget: int,
) -> int:  # fmt: skip
    """Expand up to ``budget`` cells and return why the kernel stopped.

    Parameters
    ----------
    costs, stride, weights
        As in `ppaas.planners.grid.kernels.line_of_sight.weigh`.
    offsets : (8,) int64 array
        Offsets of the neighbours of a cell, cardinal ones first, in the order of ``NEEDS``.
    least : float
        Least weight of any cell.
    toward : (height, width) float64 array
        Cost field of moves, of the map without its margin, in units of weight.
    most : float
        Cells whose cost-to-go exceeds this are skipped.
    value : (n,) float64 array
        Cost from the start of each seen cell. In and out.
    parent : (n,) int32 array
        Begin of the straight line to each seen cell; the start is its own parent. In and out.
    status : (n,) uint8 array
        UNSEEN, GUESSED, KNOWN or DONE. In and out.
    keys, cells, places
        The heap, as in `ppaas.planners.kernels.indexed_heap`. Keys: cost + heuristic, then the heuristic. In and out.
    state : (STATE_SIZE,) int64 array
        In and out.
    target : int
        Cell to reach.
    budget : int
        Number of cells to pop in this call; each `SPAN` cells on a checked line count as one more.

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
        # Pop: check the line of sight of an assumed cost first (SetVertex in the paper).
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
        # Expand: assume that unseen neighbours are visible from the parent; improve known ones by the move itself.
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
