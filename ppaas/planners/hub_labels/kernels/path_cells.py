"""Kernel: write the cells of a path run by run, each cell as one 64-bit number.

Runs are short on cluttered maps, so each store writes eight cells. The next run overwrites the excess, and the array
has space for it at its end.
"""

import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare, compiled, joined
from ppaas.planners.hub_labels.kernels import vectors
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import DIRECTIONS, Shorts, direction_of_run, last_run_of, moves_of_run
from ppaas.planners.hub_labels.kernels.vectors import AT_ONCE

Cells = NDArray[np.int32]

_vectors: Any = vectors  # `operation` returns intrinsics, which mypy takes for their generators

ROW_UNIT, COLUMN_UNIT = (1, 1 << 32) if sys.byteorder == "little" else (1 << 32, 1)
"""A cell is one int64, whose bytes are those of its row and column as int32."""

OPPOSITE = (1 << DIRECTIONS) // 2
"""Directions are counted around the circle; adding this reverses one."""

_MOVES = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))

STEPS = np.array([n * (row * ROW_UNIT + column * COLUMN_UNIT) for row, column in _MOVES for n in range(1, AT_ONCE + 1)])
"""Differences from a cell to the next eight cells, for each direction."""


@joined
def direction_of(down: int, right: int) -> int:
    """Return the direction of a step by −1, 0 or 1 rows and columns, not both 0."""
    if right == 0:
        return 2 - 2 * down
    if right > 0:
        return 2 - down
    return 6 + down


@compiled
def new_cells(count: int) -> tuple[Cells, Words]:
    """Return an array for ``count`` cells, and a view of it with one number per cell and space for the excess."""
    buffer = np.empty((count + AT_ONCE, 2), np.int32)
    return buffer[:count], buffer.reshape(2 * (count + AT_ONCE)).view(np.int64)


@joined
def write_first(flat: Words, row: int, column: int) -> tuple[int, int]:
    """Write the first cell; return the index of the next one, and the cell. Row and column include the margin."""
    cell = (row - 1) * ROW_UNIT + (column - 1) * COLUMN_UNIT
    flat[0] = cell
    return 1, cell


@joined
def write_run(flat: Words, at: int, cell: int, direction: int, moves: int) -> tuple[int, int]:
    """Write ``moves`` cells after a cell from index ``at`` on; return the index of the next one, and the last cell."""
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
    """Write the cells between two that see each other, without the first: along the diagonal, then straight."""
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
def write_path(flat: Words, at: int, cell: int, paths: Shorts, path: int) -> tuple[int, int]:
    """Write the cells of a path."""
    for place in range(path, last_run_of(paths, path) + 1):
        run = np.int64(paths[np.uint64(place)])
        at, cell = write_run(flat, at, cell, direction_of_run(run), moves_of_run(run))
    return at, cell


@bare
def write_path_backwards(flat: Words, at: int, cell: int, paths: Shorts, path: int) -> tuple[int, int]:
    """Write the cells of a path from its end to its begin."""
    for place in range(last_run_of(paths, path), path - 1, -1):
        run = np.int64(paths[np.uint64(place)])
        at, cell = write_run(flat, at, cell, direction_of_run(run) ^ OPPOSITE, moves_of_run(run))
    return at, cell
