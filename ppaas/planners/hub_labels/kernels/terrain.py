"""Kernel: lay out a map as lines of bits, in which it is a few instructions to see along a row, a column or a diagonal.

The map has a margin of one blocked cell, so no ray leaves it. All of it is one array of int64, which begins with
`HEAD` numbers: rows and columns with the margin, words of a row, words of a column (and of a diagonal, whose bits are
counted by rows too), and where the lines begin: those of the rows (per word: stops, corners, and how many corners come
before this word), of the columns (stops, corners), of the diagonals down and right, and down and left (per word: steps
that are not allowed, corners). Words of the same columns in neighbouring rows lie side by side, and so do those of the
same rows in neighbouring columns: who looks along one line looks along the next ones, too. Before the lines of rows and
behind those of columns there is room for a word beyond each line.

A *corner* is a free cell that a shortest path may have to touch as it bends: diagonal to a wall, with the two cells
between free (the simple subgoals of Uras, Koenig and Hernández, "Subgoal Graphs for Optimal Pathfinding in
Eight-Neighbor Grids", ICAPS 2013). Bit r of a diagonal stands for the step from row r to r + 1, which cuts no corner.
A line holds all diagonals that begin a whole width apart: the margin lies between them.
"""

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from ppaas.kernel_threads import at_most
from ppaas.planners.hub_labels.kernels.bits import Words, count, is_set
from ppaas.planners.kernels.jit_decorators import bare, joined

Cells = NDArray[np.uint8]

ROWS, COLUMNS, ROW_WORDS, COLUMN_WORDS, ROW_LINES, COLUMN_LINES, FALLING_LINES, RISING_LINES, SIZE = range(9)
HEAD = 16

SPARE = 4
"""Words at the end that a look ahead may read, and that mean nothing."""

BLOCK = 64
"""Rows that are laid at a time: no two blocks write to the same word."""


@joined
def row_line(terrain: Words, row: int) -> int:
    """Return where the line of a row begins."""
    return int(terrain[ROW_LINES] + row * 3)


@joined
def row_stride(terrain: Words) -> int:
    """Return the stride of the lines of rows."""
    return int(terrain[ROWS] * 3)


@joined
def column_line(terrain: Words, column: int) -> int:
    """Return where the line of a column begins."""
    return int(terrain[COLUMN_LINES] + column * 2)


@joined
def column_stride(terrain: Words) -> int:
    """Return the stride of the lines of columns."""
    return int(terrain[COLUMNS] * 2)


@joined
def diagonal_line(terrain: Words, row: int, column: int, right: int) -> int:
    """Return where the line of the diagonal through a cell begins that goes down and right or left; its stride is 2."""
    columns = terrain[COLUMNS]
    if right > 0:
        lines = terrain[FALLING_LINES]
        number = column - row if column >= row else columns - 1 - (row - column - 1) % columns
    else:
        lines = terrain[RISING_LINES]
        number = column + row if column + row < columns else (column + row) % columns
    return int(lines + number * terrain[COLUMN_WORDS] * 2)


@joined
def is_wall(terrain: Words, row: int, column: int) -> bool:
    """Tell whether a cell is blocked."""
    line, stride = row_line(terrain, row), row_stride(terrain)
    return bool(is_set(terrain, line, stride, column) and not is_set(terrain, line + 1, stride, column))


@joined
def is_corner(terrain: Words, row: int, column: int) -> bool:
    """Tell whether a cell is a corner."""
    return bool(is_set(terrain, row_line(terrain, row) + 1, row_stride(terrain), column))


@joined
def number_of(terrain: Words, row: int, column: int) -> int:
    """Return the number of the corner at a cell: corners are numbered row by row."""
    word = row_line(terrain, row) + (column >> 6) * row_stride(terrain)
    below = (np.uint64(1) << np.uint64(column & 63)) - np.uint64(1)
    place = np.uint64(word)
    return int(terrain[place + np.uint64(2)]) + count(np.uint64(terrain[place + np.uint64(1)]) & below)


@bare
def _bends(free: Cells, row: int, column: int) -> bool:
    for beside in (-1, 1):
        if free[row, column + beside]:
            for above in (-1, 1):
                if free[row + above, column] and not free[row + above, column + beside]:
                    return True
    return False


@bare
def _lay_row(free: Cells, terrain: Words, row: int, first: int, last: int) -> None:
    last_row = row == terrain[ROWS] - 1
    bit = np.int64(1) << (row & 63)
    down, below = (row >> 6) * 2, (row >> 6) * column_stride(terrain)
    line, stride = row_line(terrain, row), row_stride(terrain)
    for column in range(first, last):
        wall = not free[row, column]
        corner = not wall and _bends(free, row, column)
        word = line + (column >> 6) * stride
        upright = column_line(terrain, column) + below
        falling = diagonal_line(terrain, row, column, 1) + down
        rising = diagonal_line(terrain, row, column, -1) + down
        if wall or corner:
            terrain[word] |= np.int64(1) << (column & 63)
            terrain[upright] |= bit
        if corner:
            terrain[word + 1] |= np.int64(1) << (column & 63)
            terrain[upright + 1] |= bit
            terrain[falling + 1] |= bit
            terrain[rising + 1] |= bit
        if wall or last_row or not (free[row + 1, column] and free[row, column + 1] and free[row + 1, column + 1]):
            terrain[falling] |= bit
        if wall or last_row or not (free[row + 1, column] and free[row, column - 1] and free[row + 1, column - 1]):
            terrain[rising] |= bit


@bare
def _lay_rows(free: Cells, terrain: Words, first: int, last: int) -> None:
    for row in range(first, last):
        _lay_row(free, terrain, row, 0, terrain[COLUMNS])


@njit(cache=True, nogil=True, error_model="numpy", parallel=True)
def _lay_blocks(free: Cells, terrain: Words, first: int, last: int) -> None:
    for block in prange(first // BLOCK, (last + BLOCK - 1) // BLOCK):
        _lay_rows(free, terrain, block * BLOCK, min((block + 1) * BLOCK, last))


def lay(free: Cells, terrain: Words, first: int, last: int, threads: int) -> None:
    """Set the bits of rows ``first`` to ``last``, which begin and end with a block, on at most so many threads.

    Parameters
    ----------
    free : (rows, columns) uint8 array
        One where a cell is free, zero elsewhere and in the margin.
    terrain : int64 array
        Its head is written; its lines are zero in these rows.
    first, last, threads : int
    """
    with at_most(threads) as usable:
        kernel = _lay_blocks if usable > 1 else _lay_rows
        kernel(free, terrain, first, last)


@bare
def mend(free: Cells, terrain: Words, first_row: int, last_row: int, first_column: int, last_column: int) -> None:
    """Set the bits of a rectangle of cells anew.

    Parameters
    ----------
    free, terrain
        As for `lay`.
    first_row, last_row, first_column, last_column : int
        With the margin; the last are excluded.
    """
    for row in range(first_row, last_row):
        bit = ~(np.int64(1) << (row & 63))
        down, below = (row >> 6) * 2, (row >> 6) * column_stride(terrain)
        for column in range(first_column, last_column):
            own = ~(np.int64(1) << (column & 63))
            word = row_line(terrain, row) + (column >> 6) * row_stride(terrain)
            upright = column_line(terrain, column) + below
            falling = diagonal_line(terrain, row, column, 1) + down
            rising = diagonal_line(terrain, row, column, -1) + down
            for kind in range(2):
                terrain[word + kind] &= own
                terrain[upright + kind] &= bit
                terrain[falling + kind] &= bit
                terrain[rising + kind] &= bit
        _lay_row(free, terrain, row, first_column, last_column)


@bare
def free_cells(terrain: Words, free: Cells) -> None:
    """Write one for each free cell and zero for the others; (rows, columns) without the margin."""
    for row in range(free.shape[0]):
        for column in range(free.shape[1]):
            free[row, column] = not is_wall(terrain, row + 1, column + 1)


@bare
def number_corners(terrain: Words, places: NDArray[np.int32]) -> int:
    """Number the corners row by row, and return how many there are.

    Parameters
    ----------
    terrain : int64 array
    places : (n, 2) int32 array
        Out: row and column of each, with the margin; as many as it has room for.
    """
    corners = 0
    for row in range(terrain[ROWS]):
        line, stride = row_line(terrain, row), row_stride(terrain)
        for word in range(terrain[ROW_WORDS]):
            terrain[line + word * stride + 2] = corners
            bits = np.uint64(terrain[line + word * stride + 1])
            for bit in range(64):
                if bits == 0:
                    break
                if bits & np.uint64(1):
                    if corners < len(places):
                        places[corners, 0] = row
                        places[corners, 1] = word * 64 + bit
                    corners += 1
                bits >>= np.uint64(1)
    return corners


def warm() -> None:
    """Compile and call each kernel once."""
    free = np.zeros((3, 3), np.uint8)
    for threads in (1, 2):
        terrain = empty_terrain(3, 3)
        lay(free, terrain, 0, 3, threads)
        mend(free, terrain, 1, 2, 1, 2)
        number_corners(terrain, np.empty((0, 2), np.int32))
        terrain.flags.writeable = False
        free_cells(terrain, np.zeros((1, 1), np.uint8))


def empty_terrain(rows: int, columns: int) -> Words:
    """Return the array for a map of so many rows and columns, margin included, with its head and without a bit set."""
    row_words, column_words = (columns + 63) // 64, (rows + 63) // 64
    along = columns * column_words * 2
    room = max(rows * 3, columns * 2)
    begins = HEAD + room + np.cumsum((0, rows * row_words * 3, along + room, along, along + SPARE))
    terrain = np.zeros(begins[-1], np.int64)
    terrain[: SIZE + 1] = rows, columns, row_words, column_words, *begins
    return terrain
