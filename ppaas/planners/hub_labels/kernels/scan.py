"""Kernel: visibility scan: the corners that a cell sees, so that no other corner is on a shortest path to them.

Two cells see each other if all their shortest paths on an empty map are free. These paths fill a parallelogram with one
side along a row or column and one along a diagonal, which must contain neither a wall nor a corner. The scan steps
along each diagonal and casts a ray along the row and one along the column from each of its cells. The hit of a ray
limits all later rays (Uras, Koenig and Hernández 2013, "direct-h-reachable").
"""

import numpy as np
from numba import prange
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare, compiled, joined
from ppaas.kernel_threads import limit_threads
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

Integers = NDArray[np.int32]

STRAIGHT = 5741
"""Length of a straight move, as an integer."""

DIAGONAL = 8119
"""Length of a diagonal move, as an integer.

8119/5741 approximates √2 with an error of 1.1e-8. So if two paths differ by fewer than 5741 diagonal moves, the shorter
one is shorter in integers too. A path is never longer than a shortest one by more than 1.1e-8 per diagonal move."""

AMBIGUOUS_LENGTH = STRAIGHT * DIAGONAL
"""A length below this determines the number of moves of its path."""

_INVERSE = pow(DIAGONAL, -1, STRAIGHT)
"""Inverse of `DIAGONAL` modulo `STRAIGHT`."""

CORNERS_A_BLOCK = 256
"""Corners scanned by a thread at once."""


@joined
def _ray(words: Words, line: int, stride: int, start: int, direction: int, most: int) -> int:
    """Return −j if the ray hits a corner at its j-th cell, else the number of free cells, at most ``most``.

    Each step examines 64 cells, which span two words: most rays are shorter, and none depends on word boundaries.
    """
    bit, checked, free = start + direction, 0, 0
    shift = np.uint64(bit & 63)
    rest = np.uint64(63) - shift
    one = np.uint64(1)
    while True:
        word = np.uint64(line + ((bit >> 6) * stride))  # uint64: numba then omits the check for negative indices
        next_word = np.uint64(line + ((bit >> 6) + direction) * stride)
        if direction > 0:
            free = checked + trailing_zeros(
                (np.uint64(words[word]) >> shift) | ((np.uint64(words[next_word]) << one) << rest)
            )
        else:
            free = checked + leading_zeros(
                (np.uint64(words[word]) << rest) | ((np.uint64(words[next_word]) >> one) >> shift)
            )
        checked += 64
        if free < checked or checked >= most:
            break
        bit += 64 * direction
    if free >= most:
        return most
    return -free - 1 if is_set(words, line + 1, stride, start + direction + direction * free) else free


@joined
def octile(rows: int, columns: int) -> int:
    """Return the octile distance over this many rows and columns, as an integer."""
    rows, columns = abs(rows), abs(columns)
    return STRAIGHT * max(rows, columns) + (DIAGONAL - STRAIGHT) * min(rows, columns)


@joined
def moves_in(length: int) -> int:
    """Return the number of moves of a path, given its length below `AMBIGUOUS_LENGTH`."""
    diagonal = length * _INVERSE % STRAIGHT
    return diagonal + (length - DIAGONAL * diagonal) // STRAIGHT


@bare
def is_free(words: Words, line: int, stride: int, start: int, direction: int, most: int) -> bool:
    """Return whether ``most`` cells along a row or column are free; corners count as free."""
    while True:
        free = _ray(words, line, stride, start, direction, most)
        if free >= 0:
            return bool(free == most)
        start -= free * direction
        most += free


@joined
def diagonal_steps(terrain: Words, row: int, column: int, below: int, right: int, most: int) -> int:
    """Return the number of possible moves along a diagonal, limited to ``most``; ``below`` and ``right`` are ±1."""
    if below > 0:
        return int(up(terrain, diagonal_line(terrain, row, column, right), 2, row, most))
    return int(down(terrain, diagonal_line(terrain, row, column, -right), 2, row - 1, most))


@bare
def _sector(
    terrain: Words, row: int, column: int, below: int, right: int, most_across: int, most_along: int,
    seen: Integers, lengths: Integers, found: int,
) -> int:  # fmt: skip
    """Scan one of the four quadrants of a cell; return the new number of corners found."""
    # Steps along the diagonal up to a wall or a corner.
    most = diagonal_steps(terrain, row, column, below, right, terrain[ROWS])
    line = diagonal_line(terrain, row, column, below * right) + 1
    steps = up(terrain, line, 2, row + 1, most) if below > 0 else down(terrain, line, 2, row - 1, most)
    if steps < most:
        seen[found] = number_of(terrain, row + (steps + 1) * below, column + (steps + 1) * right)
        lengths[found] = (steps + 1) * DIAGONAL
        found += 1
    in_rows, in_columns = row_stride(terrain), column_stride(terrain)
    # Cast a ray along the row and one along the column from each diagonal cell; hits limit later rays.
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
    """Find the corners that a free cell sees, without itself, and return their number.

    Parameters
    ----------
    terrain : int64 array
        Map as lines of bits (`terrain`).
    row, column : int
        The cell, including the margin.
    seen, lengths : (at least `most_seen`,) int32 arrays
        Out: numbers of the corners, and their distances.
    """
    rows, columns = terrain[ROWS], terrain[COLUMNS]
    in_row, in_column = row_line(terrain, row), column_line(terrain, column)
    right = _ray(terrain, in_row, row_stride(terrain), column, 1, columns)
    left = _ray(terrain, in_row, row_stride(terrain), column, -1, columns)
    below = _ray(terrain, in_column, column_stride(terrain), row, 1, rows)
    above = _ray(terrain, in_column, column_stride(terrain), row, -1, rows)
    found = np.int64(0)
    # Corners in the four straight directions.
    for side in range(4):
        free, direction = (right, left, below, above)[side], 1 - 2 * (side & 1)
        if free < 0:
            r, c = (row, column - free * direction) if side < 2 else (row - free * direction, column)
            seen[found] = number_of(terrain, r, c)
            lengths[found] = -free * STRAIGHT
            found += 1
    right, left, below, above = _free_before(right), _free_before(left), _free_before(below), _free_before(above)
    # Corners in the four quadrants.
    for side in range(4):
        across, along = (right, left)[side & 1], (below, above)[side >> 1]
        found = _sector(terrain, row, column, 1 - (side & 2), 1 - 2 * (side & 1), across, along, seen, lengths, found)
    return int(found)


@joined
def _free_before(free: int) -> int:
    """Return the number of free cells before a wall or corner, given the result of a ray."""
    return free if free >= 0 else -free - 1


def most_seen(rows: int, columns: int, corners: int) -> int:
    """Return an upper bound of the number of corners that a cell sees."""
    return min(corners, 4 + 4 * (1 + 2 * min(rows, columns))) + 1


@compiled
def _scan_range(
    terrain: Words, positions: Integers, most: int, first: int, last: int,
    starts: Words, to: Integers, lengths: Integers,
) -> None:  # fmt: skip
    seen, far = np.empty(most, np.int32), np.empty(most, np.int32)
    for corner in range(first, last):
        found = scan(terrain, np.int64(positions[corner, 0]), np.int64(positions[corner, 1]), seen, far)
        if len(to) == 0:
            starts[corner + 1] = found
        else:
            begin = starts[corner]
            for i in range(found):
                to[begin + i] = seen[i]
                lengths[begin + i] = far[i]


@compiled(parallel=True)
def _scan_blocks(
    terrain: Words, positions: Integers, most: int, first: int, last: int,
    starts: Words, to: Integers, lengths: Integers,
) -> None:  # fmt: skip
    for block in prange((last - first + CORNERS_A_BLOCK - 1) // CORNERS_A_BLOCK):
        begin = first + block * CORNERS_A_BLOCK
        _scan_range(terrain, positions, most, begin, min(begin + CORNERS_A_BLOCK, last), starts, to, lengths)


def scan_corners(
    terrain: Words, positions: Integers, first: int, last: int,
    starts: Words, to: Integers, lengths: Integers, threads: int,
) -> None:  # fmt: skip
    """Find the corners that each of the corners ``first`` to ``last`` (excluded) sees.

    Parameters
    ----------
    terrain : int64 array
        Map as lines of bits; read-only.
    positions : (n, 2) int32 array
        Row and column of each corner, including the margin.
    first, last : int
        Range of the corners.
    starts : (n + 1,) int64 array
        First entry of each corner. If ``to`` is empty, out: the number of corners seen, at ``corner + 1``.
    to, lengths : (m,) int32 arrays
        Out: the corners seen and their distances. If both are empty, corners are only counted.
    threads : int
        Maximum number of threads.
    """
    most = most_seen(int(terrain[ROWS]), int(terrain[COLUMNS]), len(positions))
    with limit_threads(threads) as usable:
        kernel = _scan_blocks if usable > 1 else _scan_range
        kernel(terrain, positions, most, first, last, starts, to, lengths)


def warm() -> None:
    """Compile and call each kernel once."""
    for threads in (1, 2):
        nothing, terrain = np.empty(0, np.int32), empty_terrain(3, 3)
        terrain.flags.writeable = False
        scan_corners(terrain, np.empty((0, 2), np.int32), 0, 0, np.zeros(1, np.int64), nothing, nothing, threads)
