"""Kernel: write the cells of a path, each as one number of 64 bits, run by run.

Runs are short where a map is cluttered, so eight cells are written at a time, whether they are wanted or not: what is
too much is written over by the next run, and room for it is left at the end.
"""

import sys
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.planners.hub_labels.kernels import vectors
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import DIRECTIONS, Shorts, direction_of_run, last_run_of, moves_of_run
from ppaas.planners.hub_labels.kernels.vectors import AT_ONCE
from ppaas.planners.kernels.jit_decorators import bare, joined

Cells = NDArray[np.int32]

_vectors: Any = vectors  # numba's annotations take what makes an operation for the operation

ROW_UNIT, COLUMN_UNIT = (1, 1 << 32) if sys.byteorder == "little" else (1 << 32, 1)
"""A cell is written as one int64, which lies in memory as its row and its column do."""

OPPOSITE = (1 << DIRECTIONS) // 2
"""Directions go round: that which is so many further leads back."""

_ROUND = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))
STEPS = np.array([n * (row * ROW_UNIT + column * COLUMN_UNIT) for row, column in _ROUND for n in range(1, AT_ONCE + 1)])
"""By how much the next eight cells in each direction differ from the one before."""


@joined
def direction_of(down: int, right: int) -> int:
    """Return the direction of a step by −1, 0 or 1 rows and columns; they may not both be 0."""
    if right == 0:
        return 2 - 2 * down
    if right > 0:
        return 2 - down
    return 6 + down


@njit(cache=True, nogil=True, error_model="numpy")
def new_cells(count: int) -> tuple[Cells, Words]:
    """Return room for so many cells, and the same as one number a cell, with some to spare."""
    room = np.empty((count + AT_ONCE, 2), np.int32)
    return room[:count], room.reshape(2 * (count + AT_ONCE)).view(np.int64)


@joined
def write_first(flat: Words, row: int, column: int) -> tuple[int, int]:
    """Write the first cell, and return where the next begin, and the cell. Rows and columns count the margin here."""
    cell = (row - 1) * ROW_UNIT + (column - 1) * COLUMN_UNIT
    flat[0] = cell
    return 1, cell


@joined
def write_run(flat: Words, at: int, cell: int, direction: int, moves: int) -> tuple[int, int]:
    """Write so many cells after one, from ``at`` on, and return where the next begin, and the last cell."""
    steps, last = direction * AT_ONCE, cell + moves * STEPS[np.uint64(direction * AT_ONCE)]
    _vectors.write_next(flat, at, cell, STEPS, steps)
    for begin in range(AT_ONCE, moves, AT_ONCE):
        cell += STEPS[np.uint64(steps + AT_ONCE - 1)]
        _vectors.write_next(flat, at + begin, cell, STEPS, steps)
    return at + moves, last


@bare
def write_straight(
    flat: Words, at: int, cell: int, row: int, column: int, to_row: int, to_column: int
) -> tuple[int, int]:
    """Write the cells between two that see each other, without the first, along the diagonal first."""
    rows, columns = to_row - row, to_column - column
    down, right = (rows > 0) - (rows < 0), (columns > 0) - (columns < 0)
    rows, columns = abs(rows), abs(columns)
    diagonal = min(rows, columns)
    if diagonal > 0:
        at, cell = write_run(flat, at, cell, direction_of(down, right), diagonal)
    if rows > columns:
        at, cell = write_run(flat, at, cell, direction_of(down, 0), rows - diagonal)
    elif columns > rows:
        at, cell = write_run(flat, at, cell, direction_of(0, right), columns - diagonal)
    return at, cell


@bare
def write_way(flat: Words, at: int, cell: int, ways: Shorts, way: int) -> tuple[int, int]:
    """Write the cells of a way."""
    for place in range(way, last_run_of(ways, way) + 1):
        run = np.int64(ways[np.uint64(place)])
        at, cell = write_run(flat, at, cell, direction_of_run(run), moves_of_run(run))
    return at, cell


@bare
def write_back(flat: Words, at: int, cell: int, ways: Shorts, way: int) -> tuple[int, int]:
    """Write the cells of a way from its end to its begin."""
    for place in range(last_run_of(ways, way), way - 1, -1):
        run = np.int64(ways[np.uint64(place)])
        at, cell = write_run(flat, at, cell, direction_of_run(run) ^ OPPOSITE, moves_of_run(run))
    return at, cell
