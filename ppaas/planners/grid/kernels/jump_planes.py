"""Kernel: bit planes of the ends of straight jumps, computed once per map.

A straight jump ends before a blocked cell; at a cell beside which an obstacle ends (only there must a cheapest path be
able to turn); and at a *mixed* cell, which has free cells of different costs among itself and its eight neighbours, so
that the symmetry behind jumps does not hold. All three depend on the map only. A jump then scans 64 cells per word:
block-based scanning (Harabor and Grastien, "Improving Jump Point Search", 2014) with precomputed masks.

Planes are (plane, line, word) arrays of bits, see `ppaas.planners.kernels.bits`. Lines are the rows of the padded map,
or its columns; everything beyond it counts as blocked.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

Planes = NDArray[np.uint64]
Bytes = NDArray[np.uint8]
Ints = NDArray[np.int64]

FREE, MIXED, AHEAD, BACK, SQUARE = range(5)
"""Planes: free cells; mixed cells; ends of jumps towards higher positions, and towards lower ones; first cells of a
free 2×2 square with the next cell of the line and the two cells of the next line, which a diagonal move may cross."""

_1, _63 = np.uint64(1), np.uint64(63)


@compiled
def mark_cells(costs: Bytes, weights: Ints, one_cost: bool, rows: Planes, first: int, last: int) -> None:
    """Write the planes of free and of mixed cells for rows ``first`` to ``last``.

    Parameters
    ----------
    costs : (height, width) uint8 array
        Costs of the padded map.
    weights : (256,) int64 array
        Weight of each cost; 0 is blocked.
    one_cost : bool
        Whether all free cells cost the same, so that none is mixed.
    rows : (5, height, words) uint64 array
        Out: the planes `FREE` and `MIXED`.
    first, last : int
        Range of rows, ``last`` excluded.
    """
    height, width = costs.shape
    for row in range(first, last):
        for word in range(rows.shape[2]):
            free, mixed = np.uint64(0), np.uint64(0)
            for column in range(word * 64, min(word * 64 + 64, width)):
                if weights[costs[row, column]] > 0:
                    free |= _1 << np.uint64(column & 63)
            rows[FREE, row, word] = free
            rows[MIXED, row, word] = mixed
    if one_cost:
        return
    for row in range(max(first, 1), min(last, height - 1)):
        for column in range(1, width - 1):
            cost = costs[row, column]
            if weights[cost] == 0:
                continue
            for beside in range(9):
                other = costs[row + beside // 3 - 1, column + beside % 3 - 1]
                if other != cost and weights[other] > 0:
                    rows[MIXED, row, column >> 6] |= _1 << np.uint64(column & 63)
                    break


@compiled
def _transposed(source: Planes, plane: int, line: int, word: int, block: Planes) -> None:
    """Transpose a block of 64×64 bits (Warren, "Hacker's Delight", 2012, 7–3); lines beyond the map are zero."""
    for i in range(64):
        block[i] = source[plane, line + i, word] if line + i < source.shape[1] else np.uint64(0)
    width, mask = np.uint64(32), np.uint64(0x00000000FFFFFFFF)
    while width > 0:
        step = int(np.int64(width))
        at = 0
        while at < 64:
            swapped = ((block[at] >> width) ^ block[at + step]) & mask
            block[at] ^= swapped << width
            block[at + step] ^= swapped
            at = (at + step + 1) & ~step
        width >>= _1
        mask ^= mask << width


@compiled
def turn(rows: Planes, columns: Planes, first: int, last: int) -> None:
    """Write words ``first`` to ``last`` of the columns' planes `FREE` and `MIXED`, by transposing the rows' planes."""
    block = np.empty(64, np.uint64)
    for plane in (FREE, MIXED):
        for word in range(first, last):
            for place in range(rows.shape[2]):
                _transposed(rows, plane, word * 64, place, block)
                for i in range(min(64, columns.shape[1] - place * 64)):
                    columns[plane, place * 64 + i, word] = block[i]


@compiled
def mark_jumps(planes: Planes, first: int, last: int) -> None:
    """Write the other planes for lines ``first`` to ``last`` (rows or columns), from those of free and mixed cells.

    An obstacle beside the line ends where a cell of an adjacent line is free and the one before it is blocked.
    """
    words = planes.shape[2]
    blank = np.uint64(0)
    for line in range(first, last):
        above, below = min(line + 1, planes.shape[1] - 1), max(line - 1, 0)
        for word in range(words):
            free = planes[FREE, line, word]
            ahead = back = ~free | planes[MIXED, line, word]
            for beside in (above, below):
                here = planes[FREE, beside, word]
                before = planes[FREE, beside, word - 1] if word > 0 else blank
                behind = planes[FREE, beside, word + 1] if word + 1 < words else blank
                ahead |= here & ~((here << _1) | (before >> _63))
                back |= here & ~((here >> _1) | (behind << _63))
            planes[AHEAD, line, word] = ahead
            planes[BACK, line, word] = back
            both = free & planes[FREE, above, word]
            after = blank
            if word + 1 < words:
                after = planes[FREE, line, word + 1] & planes[FREE, above, word + 1]
            planes[SQUARE, line, word] = both & ((both >> _1) | (after << _63))


def warm() -> None:
    """Compile and call each kernel once."""
    rows, columns = np.zeros((5, 3, 1), np.uint64), np.zeros((5, 3, 1), np.uint64)
    mark_cells(np.zeros((3, 3), np.uint8), np.ones(256, np.int64), False, rows, 0, 3)
    turn(rows, columns, 0, 1)
    mark_jumps(rows, 0, 3)
