"""Kernel: write the cells of a path, each as one number of 64 bits.

Ways between corners are short where a map is cluttered, so four cells are written at a time, whether they are wanted or
not: what is too much is written over by the next way, and room for it is left at the end.
"""

import sys

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.kernels.bare import joined

Cells = NDArray[np.int32]

ROW_UNIT, COLUMN_UNIT = (1, 1 << 32) if sys.byteorder == "little" else (1 << 32, 1)
"""A cell is written as one int64, which lies in memory as its row and its column do."""

AT_ONCE = 4


@njit(cache=True, nogil=True, error_model="numpy")
def new_cells(count: int) -> tuple[Cells, Words]:
    """Return room for so many cells, and the same as one number a cell, with some to spare."""
    room = np.empty((count + AT_ONCE, 2), np.int32)
    return room[:count], room.reshape(2 * (count + AT_ONCE)).view(np.int64)


@joined
def write_first(flat: Words, row: int, column: int) -> int:
    """Write the first cell, and return where the next begin. Rows and columns are counted with the margin here."""
    flat[0] = (row - 1) * ROW_UNIT + (column - 1) * COLUMN_UNIT
    return 1


@joined
def write_cells(flat: Words, at: int, row: int, column: int, to_row: int, to_column: int) -> int:
    """Write the cells between two that see each other from ``at`` on, without the first; return where they end."""
    rows, columns = to_row - row, to_column - column
    down = ROW_UNIT if rows > 0 else -ROW_UNIT
    right = COLUMN_UNIT if columns > 0 else -COLUMN_UNIT
    rows, columns = abs(rows), abs(columns)
    diagonal, count = min(rows, columns), max(rows, columns)
    straight, both = down if rows > columns else right, down + right
    cell = (row - 1) * ROW_UNIT + (column - 1) * COLUMN_UNIT
    for i in range(AT_ONCE):
        cell += both if i < diagonal else straight
        flat[np.uint64(at + i)] = cell
    if count > AT_ONCE:
        for i in range(AT_ONCE, diagonal):
            flat[np.uint64(at + i)] = cell + (i + 1 - AT_ONCE) * both
        cell += max(0, diagonal - AT_ONCE) * both
        begin = max(AT_ONCE, diagonal)
        for i in range(begin, count):
            flat[np.uint64(at + i)] = cell + (i + 1 - begin) * straight
    return int(at + count)
