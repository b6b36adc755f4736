"""Kernel: a map as lines of bits, for fast rays along rows, columns and diagonals.

The map has a margin of one blocked cell, so no ray leaves it. The int64 array begins with `HEAD` numbers: rows and
columns including the margin; words of a row; words of a column (and of a diagonal, whose bits are also indexed by row);
and the begin of each group of lines:

* rows, three words side by side: stops (walls and corners), corners, and the number of corners before this word;
* columns, two words: stops, corners;
* diagonals down and right, then diagonals down and left, two words: forbidden moves, corners.

Words of the same columns in adjacent rows are adjacent, and likewise words of the same rows in adjacent columns: a scan
along one line continues with the next ones. Before the rows and after the columns there is space for a word beyond each
line.

A *corner* is a free cell at which a shortest path may have to turn: diagonal to a wall, with the two cells between them
free (the simple subgoals of Uras, Koenig and Hernández, "Subgoal Graphs for Optimal Pathfinding in Eight-Neighbor
Grids", ICAPS 2013). Bit r of a diagonal stands for the move from row r to r + 1; moves never cut corners. A line holds
all diagonals that begin one map width apart, separated by the margin.
"""

import numpy as np
from numba import prange
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare, compiled, joined
from ppaas.kernel_threads import limit_threads
from ppaas.planners.hub_labels.kernels.bits import Words, count, is_set

Cells = NDArray[np.uint8]

ROWS, COLUMNS, ROW_WORDS, COLUMN_WORDS, ROW_LINES, COLUMN_LINES, FALLING_LINES, RISING_LINES, SIZE = range(9)
"""Header: rows and columns including the margin, words of a row and of a column, begin of each group of lines, and the
end of the array."""

HEAD = 16
"""Length of the header [words]."""

SPARE = 4
"""Padding words at the end, which rays may read; their value does not matter."""

BLOCK = 64
"""Rows written at once: different blocks never write to the same word."""


@joined
def row_line(terrain: Words, row: int) -> int:
    """Return the begin of the line of a row."""
    return int(terrain[ROW_LINES] + row * 3)


@joined
def row_stride(terrain: Words) -> int:
    """Return the stride of row lines."""
    return int(terrain[ROWS] * 3)


@joined
def column_line(terrain: Words, column: int) -> int:
    """Return the begin of the line of a column."""
    return int(terrain[COLUMN_LINES] + column * 2)


@joined
def column_stride(terrain: Words) -> int:
    """Return the stride of column lines."""
    return int(terrain[COLUMNS] * 2)


@joined
def diagonal_line(terrain: Words, row: int, column: int, right: int) -> int:
    """Return the begin of the line of the diagonal through a cell; its stride is 2.

    The diagonal goes down and right if ``right`` is positive, else down and left.
    """
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
    """Return whether a cell is blocked."""
    line, stride = row_line(terrain, row), row_stride(terrain)
    return bool(is_set(terrain, line, stride, column) and not is_set(terrain, line + 1, stride, column))


@joined
def is_corner(terrain: Words, row: int, column: int) -> bool:
    """Return whether a cell is a corner."""
    return bool(is_set(terrain, row_line(terrain, row) + 1, row_stride(terrain), column))


@joined
def number_of(terrain: Words, row: int, column: int) -> int:
    """Return the number of the corner at a cell. Corners are numbered row by row."""
    word = row_line(terrain, row) + (column >> 6) * row_stride(terrain)
    below = (np.uint64(1) << np.uint64(column & 63)) - np.uint64(1)
    place = np.uint64(word)
    return int(terrain[place + np.uint64(2)]) + count(np.uint64(terrain[place + np.uint64(1)]) & below)


@bare
def _is_corner(free: Cells, row: int, column: int) -> bool:
    for side in (-1, 1):
        if free[row, column + side]:
            for up in (-1, 1):
                if free[row + up, column] and not free[row + up, column + side]:
                    return True
    return False


@bare
def _write_row(free: Cells, terrain: Words, row: int, first: int, last: int) -> None:
    last_row = row == terrain[ROWS] - 1
    bit = np.int64(1) << (row & 63)
    down, below = (row >> 6) * 2, (row >> 6) * column_stride(terrain)
    line, stride = row_line(terrain, row), row_stride(terrain)
    for column in range(first, last):
        wall = not free[row, column]
        corner = not wall and _is_corner(free, row, column)
        word = line + (column >> 6) * stride
        column_word = column_line(terrain, column) + below
        falling_word = diagonal_line(terrain, row, column, 1) + down
        rising_word = diagonal_line(terrain, row, column, -1) + down
        if wall or corner:
            terrain[word] |= np.int64(1) << (column & 63)
            terrain[column_word] |= bit
        if corner:
            terrain[word + 1] |= np.int64(1) << (column & 63)
            terrain[column_word + 1] |= bit
            terrain[falling_word + 1] |= bit
            terrain[rising_word + 1] |= bit
        if wall or last_row or not (free[row + 1, column] and free[row, column + 1] and free[row + 1, column + 1]):
            terrain[falling_word] |= bit
        if wall or last_row or not (free[row + 1, column] and free[row, column - 1] and free[row + 1, column - 1]):
            terrain[rising_word] |= bit


@bare
def _write_rows(free: Cells, terrain: Words, first: int, last: int) -> None:
    for row in range(first, last):
        _write_row(free, terrain, row, 0, terrain[COLUMNS])


@compiled(parallel=True)
def _write_blocks(free: Cells, terrain: Words, first: int, last: int) -> None:
    for block in prange(first // BLOCK, (last + BLOCK - 1) // BLOCK):
        _write_rows(free, terrain, block * BLOCK, min((block + 1) * BLOCK, last))


def write_lines(free: Cells, terrain: Words, first: int, last: int, threads: int) -> None:
    """Set the bits of rows ``first`` to ``last``, which begin and end with a block.

    Parameters
    ----------
    free : (rows, columns) uint8 array
        1 for free cells, 0 for blocked cells and the margin.
    terrain : int64 array
        The lines, zero in these rows; the header is complete.
    first, last : int
        Range of the rows.
    threads : int
        Maximum number of threads.
    """
    with limit_threads(threads) as usable:
        kernel = _write_blocks if usable > 1 else _write_rows
        kernel(free, terrain, first, last)


@bare
def rewrite_rectangle(
    free: Cells, terrain: Words, first_row: int, last_row: int, first_column: int, last_column: int
) -> None:
    """Set the bits of a rectangle of cells again.

    Parameters
    ----------
    free, terrain
        As for `write_lines`.
    first_row, last_row, first_column, last_column : int
        The rectangle including the margin, ends excluded.
    """
    for row in range(first_row, last_row):
        bit = ~(np.int64(1) << (row & 63))
        down, below = (row >> 6) * 2, (row >> 6) * column_stride(terrain)
        for column in range(first_column, last_column):
            row_mask = ~(np.int64(1) << (column & 63))
            word = row_line(terrain, row) + (column >> 6) * row_stride(terrain)
            column_word = column_line(terrain, column) + below
            falling_word = diagonal_line(terrain, row, column, 1) + down
            rising_word = diagonal_line(terrain, row, column, -1) + down
            for kind in range(2):
                terrain[word + kind] &= row_mask
                terrain[column_word + kind] &= bit
                terrain[falling_word + kind] &= bit
                terrain[rising_word + kind] &= bit
        _write_row(free, terrain, row, first_column, last_column)


@bare
def free_cells(terrain: Words, free: Cells) -> None:
    """Write 1 for each free cell and 0 for the others; ``free`` is (rows, columns) without the margin."""
    for row in range(free.shape[0]):
        for column in range(free.shape[1]):
            free[row, column] = not is_wall(terrain, row + 1, column + 1)


@bare
def number_corners(terrain: Words, positions: NDArray[np.int32]) -> int:
    """Number the corners row by row, and return their number.

    Parameters
    ----------
    terrain : int64 array
        The lines. Out: the number of corners before each word.
    positions : (n, 2) int32 array
        Out: row and column of the first n corners, including the margin.
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
                    if corners < len(positions):
                        positions[corners, 0] = row
                        positions[corners, 1] = word * 64 + bit
                    corners += 1
                bits >>= np.uint64(1)
    return corners


def warm() -> None:
    """Compile and call each kernel once."""
    free = np.zeros((3, 3), np.uint8)
    for threads in (1, 2):
        terrain = empty_terrain(3, 3)
        write_lines(free, terrain, 0, 3, threads)
        rewrite_rectangle(free, terrain, 1, 2, 1, 2)
        number_corners(terrain, np.empty((0, 2), np.int32))
        terrain.flags.writeable = False
        free_cells(terrain, np.zeros((1, 1), np.uint8))


def empty_terrain(rows: int, columns: int) -> Words:
    """Return the array for a map of this size, margin included, with its header and all bits zero."""
    row_words, column_words = (columns + 63) // 64, (rows + 63) // 64
    along = columns * column_words * 2
    spare = max(rows * 3, columns * 2)
    begins = HEAD + spare + np.cumsum((0, rows * row_words * 3, along + spare, along, along + SPARE))
    terrain = np.zeros(begins[-1], np.int64)
    terrain[: SIZE + 1] = rows, columns, row_words, column_words, *begins
    return terrain
