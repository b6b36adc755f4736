"""Kernel: which corners can be seen from a cell, so that no other corner is on a shortest way there.

Two cells see each other if all shortest ways between them that an empty map would have are free: they fill a
parallelogram with one side along a row or column and one along a diagonal, in which there is neither a wall nor a
corner. Along the diagonal, a ray is sent at each cell along the row and one along the column; what a ray meets bounds
all rays after it (Uras, Koenig and Hernández 2013, "direct-h-reachable").
"""

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from ppaas.kernel_threads import at_most
from ppaas.planners.hub_labels.kernels.bits import Words, down, is_set, up
from ppaas.planners.hub_labels.kernels.terrain import (
    COLUMNS,
    ROWS,
    column_line,
    column_stride,
    diagonal_line,
    empty_terrain,
    number_of,
    row_line,
    row_stride,
)
from ppaas.planners.kernels.bits import leading_zeros, trailing_zeros
from ppaas.planners.kernels.jit_decorators import bare, joined

Integers = NDArray[np.int32]

STRAIGHT = 5741
DIAGONAL = 8119
"""A step's length in whole numbers: 8119/5741 is √2 but for 1.1e-8. So of two ways that differ by fewer than 5741
diagonal steps the shorter one is shorter in whole numbers too, and a way found is never longer than a shortest one by
more than 1.1e-8 a diagonal step."""

TELLING = STRAIGHT * DIAGONAL
"""Shorter lengths tell of how many moves a way is."""

_INVERSE = pow(DIAGONAL, -1, STRAIGHT)

CLUMP = 256
"""Corners that are scanned at a time."""


@joined
def _ray(words: Words, line: int, stride: int, at: int, way: int, most: int) -> int:
    """Return −j if the ray meets a corner at its cell j, else how many free cells come before a wall, or ``most``.

    It looks at 64 cells at a time, of two words: most rays are shorter, and none of them depends on where words begin.
    """
    bit, passed, free = at + way, 0, 0
    shift = np.uint64(bit & 63)
    rest = np.uint64(63) - shift
    one = np.uint64(1)
    while True:
        here = np.uint64(line + ((bit >> 6) * stride))  # what cannot count from the end needs no look whether it does
        beside = np.uint64(line + ((bit >> 6) + way) * stride)
        if way > 0:
            free = passed + trailing_zeros(
                (np.uint64(words[here]) >> shift) | ((np.uint64(words[beside]) << one) << rest)
            )
        else:
            free = passed + leading_zeros(
                (np.uint64(words[here]) << rest) | ((np.uint64(words[beside]) >> one) >> shift)
            )
        passed += 64
        if free < passed or passed >= most:
            break
        bit += 64 * way
    if free >= most:
        return most
    return -free - 1 if is_set(words, line + 1, stride, at + way + way * free) else free


@joined
def octile(rows: int, columns: int) -> int:
    """Return how long a way over so many rows and columns is at least, in whole numbers."""
    rows, columns = abs(rows), abs(columns)
    return STRAIGHT * max(rows, columns) + (DIAGONAL - STRAIGHT) * min(rows, columns)


@joined
def moves_in(length: int) -> int:
    """Return of how many moves a way is, from its length; only for lengths below `TELLING`."""
    diagonal = length * _INVERSE % STRAIGHT
    return diagonal + (length - DIAGONAL * diagonal) // STRAIGHT


@bare
def is_free(words: Words, line: int, stride: int, at: int, way: int, most: int) -> bool:
    """Tell whether so many cells are free along a row or column, corners or not."""
    while True:
        free = _ray(words, line, stride, at, way, most)
        if free >= 0:
            return bool(free == most)
        at -= free * way
        most += free


@joined
def diagonal_steps(terrain: Words, row: int, column: int, below: int, right: int, most: int) -> int:
    """Return how many steps, up to ``most``, can be made along a diagonal; ``below`` and ``right`` are ±1."""
    if below > 0:
        return int(up(terrain, diagonal_line(terrain, row, column, right), 2, row, most))
    return int(down(terrain, diagonal_line(terrain, row, column, -right), 2, row - 1, most))


@bare
def _sector(
    terrain: Words, row: int, column: int, below: int, right: int, most_across: int, most_along: int,
    seen: Integers, lengths: Integers, found: int,
) -> int:  # fmt: skip
    most = diagonal_steps(terrain, row, column, below, right, terrain[ROWS])
    line = diagonal_line(terrain, row, column, below * right) + 1
    steps = up(terrain, line, 2, row + 1, most) if below > 0 else down(terrain, line, 2, row - 1, most)
    if steps < most:
        seen[found] = number_of(terrain, row + (steps + 1) * below, column + (steps + 1) * right)
        lengths[found] = (steps + 1) * DIAGONAL
        found += 1
    in_rows, in_columns = row_stride(terrain), column_stride(terrain)
    for step in range(1, steps + 1):
        if most_across == 0 and most_along == 0:
            break
        r, c = row + step * below, column + step * right
        free = _ray(terrain, row_line(terrain, r), in_rows, c, right, most_across)
        if free < 0:
            seen[found] = number_of(terrain, r, c - free * right)
            lengths[found] = step * DIAGONAL - free * STRAIGHT
            found += 1
            free = -free - 1
        most_across = free
        free = _ray(terrain, column_line(terrain, c), in_columns, r, below, most_along)
        if free < 0:
            seen[found] = number_of(terrain, r - free * below, c)
            lengths[found] = step * DIAGONAL - free * STRAIGHT
            found += 1
            free = -free - 1
        most_along = free
    return found


@bare
def scan(terrain: Words, row: int, column: int, seen: Integers, lengths: Integers) -> int:
    """Find the corners that a free cell sees, without itself, and return how many there are.

    Parameters
    ----------
    terrain : int64 array
    row, column : int
        With the margin.
    seen, lengths : (at least `most_seen`,) int32 arrays
        Out: numbers of the corners, and how long the ways there are.
    """
    rows, columns = terrain[ROWS], terrain[COLUMNS]
    in_row, in_column = row_line(terrain, row), column_line(terrain, column)
    right = _ray(terrain, in_row, row_stride(terrain), column, 1, columns)
    left = _ray(terrain, in_row, row_stride(terrain), column, -1, columns)
    below = _ray(terrain, in_column, column_stride(terrain), row, 1, rows)
    above = _ray(terrain, in_column, column_stride(terrain), row, -1, rows)
    found = np.int64(0)
    for side in range(4):
        free, way = (right, left, below, above)[side], 1 - 2 * (side & 1)
        if free < 0:
            r, c = (row, column - free * way) if side < 2 else (row - free * way, column)
            seen[found] = number_of(terrain, r, c)
            lengths[found] = -free * STRAIGHT
            found += 1
    right, left, below, above = _clear(right), _clear(left), _clear(below), _clear(above)
    for side in range(4):
        across, along = (right, left)[side & 1], (below, above)[side >> 1]
        found = _sector(terrain, row, column, 1 - (side & 2), 1 - 2 * (side & 1), across, along, seen, lengths, found)
    return int(found)


@joined
def _clear(free: int) -> int:
    """Return how many cells are free of walls and corners, of what a ray told."""
    return free if free >= 0 else -free - 1


def most_seen(rows: int, columns: int, corners: int) -> int:
    """Return how many corners a cell can see at most."""
    return min(corners, 4 + 4 * (1 + 2 * min(rows, columns))) + 1


@njit(cache=True, nogil=True, error_model="numpy")
def _scan_some(
    terrain: Words, places: Integers, most: int, first: int, last: int,
    starts: Words, to: Integers, lengths: Integers,
) -> None:  # fmt: skip
    seen, far = np.empty(most, np.int32), np.empty(most, np.int32)
    for corner in range(first, last):
        found = scan(terrain, np.int64(places[corner, 0]), np.int64(places[corner, 1]), seen, far)
        if len(to) == 0:
            starts[corner + 1] = found
        else:
            begin = starts[corner]
            for i in range(found):
                to[begin + i] = seen[i]
                lengths[begin + i] = far[i]


@njit(cache=True, nogil=True, error_model="numpy", parallel=True)
def _scan_clumps(
    terrain: Words, places: Integers, most: int, first: int, last: int,
    starts: Words, to: Integers, lengths: Integers,
) -> None:  # fmt: skip
    for clump in prange((last - first + CLUMP - 1) // CLUMP):
        begin = first + clump * CLUMP
        _scan_some(terrain, places, most, begin, min(begin + CLUMP, last), starts, to, lengths)


def scan_corners(
    terrain: Words, places: Integers, first: int, last: int,
    starts: Words, to: Integers, lengths: Integers, threads: int,
) -> None:  # fmt: skip
    """Find what the corners ``first`` to ``last`` see, on at most so many threads.

    Parameters
    ----------
    terrain : int64 array
        Nobody can write to it.
    places : (n, 2) int32 array
    first, last : int
    starts : (n + 1,) int64 array
        Where the corners that a corner sees begin; out, if ``to`` is empty: at ``corner + 1``, how many it sees.
    to, lengths : (m,) int32 arrays
        Out: which, and how far. Or both empty: they are only counted.
    threads : int
    """
    most = most_seen(int(terrain[ROWS]), int(terrain[COLUMNS]), len(places))
    with at_most(threads) as usable:
        kernel = _scan_clumps if usable > 1 else _scan_some
        kernel(terrain, places, most, first, last, starts, to, lengths)


def warm() -> None:
    """Compile and call each kernel once."""
    for threads in (1, 2):
        nothing, terrain = np.empty(0, np.int32), empty_terrain(3, 3)
        terrain.flags.writeable = False
        scan_corners(terrain, np.empty((0, 2), np.int32), 0, 0, np.zeros(1, np.int64), nothing, nothing, threads)
