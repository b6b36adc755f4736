"""Table of the directions in which a path continues from a cell, for the kernel of jump point search.

Directions are 0 to 7: towards higher columns, higher rows, lower columns, lower rows, and the diagonals between these:
4 is between 0 and 1, 7 between 3 and 0. A set of directions is a number with one bit for each.

A neighbourhood is a number of nine bits, one for each free cell: the lower row in the lowest three bits, by column.
"""

import numpy as np
from numpy.typing import NDArray

DOWN = (0, 1, 0, -1, 1, 1, -1, -1)
RIGHT = (1, 0, -1, 0, 1, -1, -1, 1)
"""Rows and columns of a move in each direction."""

ANY = 8
"""Index of the table for the start of a search, which continues to all free neighbours."""

MIXED = 9
"""Added to a direction as the index of the table for a mixed cell, whose neighbours do not all weigh the same."""


def _free(down: int, right: int) -> NDArray[np.bool_]:
    """Return for each neighbourhood whether the cell at an offset is free."""
    return np.asarray((np.arange(512) >> ((down + 1) * 3 + right + 1)) & 1, np.bool_)


def _allowed(direction: int) -> NDArray[np.bool_]:
    """Return for each neighbourhood whether a move is possible; a diagonal one needs both cells beside it free."""
    down, right = DOWN[direction], RIGHT[direction]
    return _free(down, right) & _free(down, 0) & _free(0, right)


def _parts(direction: int) -> tuple[int, int]:
    """Return the two cardinal directions that enclose a diagonal one."""
    return direction - 4, (direction - 3) & 3


def _straight(direction: int) -> NDArray[np.bool_]:
    """Return the directions after a cardinal move: straight on, and to a side where an obstacle has just ended."""
    into = np.zeros((8, 512), np.bool_)
    into[direction] = True
    for side in ((direction + 1) & 3, (direction - 1) & 3):
        back = (DOWN[side] - DOWN[direction], RIGHT[side] - RIGHT[direction])
        ended = _free(DOWN[side], RIGHT[side]) & ~_free(*back)
        diagonal = next(d for d in range(4, 8) if set(_parts(d)) == {direction, side})
        into[side] |= ended
        into[diagonal] |= ended
    return into


def _mixed(direction: int) -> NDArray[np.bool_]:
    """Return the directions at a mixed cell: all except back, and to cells adjacent to the previous one."""
    into = np.ones((8, 512), np.bool_)
    for onward in range(8):
        beside = (DOWN[onward] + DOWN[direction], RIGHT[onward] + RIGHT[direction])
        into[onward] = abs(beside[0]) + abs(beside[1]) > 1
    return into


def turns() -> NDArray[np.uint8]:
    """Return the (17, 512) sets of directions to continue in, by incoming direction and neighbourhood."""
    table = np.zeros((MIXED + 8, 512), np.uint8)
    for came in range(MIXED + 8):
        into = np.ones((8, 512), np.bool_)
        if came < 4:
            into = _straight(came)
        elif came < ANY:
            into[:] = False
            into[[came, *_parts(came)]] = True
        elif came >= MIXED:
            into = _mixed(came - MIXED)
        for direction in range(8):
            table[came] |= (into[direction] & _allowed(direction)).astype(np.uint8) << np.uint8(direction)
    return table
