"""Kernel: directions of moves between neighbouring cells, and the quarter turns between them.

Directions are 0 to the next row, 1 to the next column, 2 to the row before, and 3 to the column before. A robot drives
forwards only, and its first direction is free.
"""

import numpy as np

from ppaas.fleet.kernels.board import Ints
from ppaas.kernel_cache.decorators import bare, joined

DIRECTIONS = 4


@joined
def direction(cells: Ints, start: int, end: int) -> int:
    """Return the direction of a move between two neighbouring cells.

    Parameters
    ----------
    cells : (v, 2) int32 array
        Row and column of each cell.
    start, end : int
    """
    down = cells[end, 0] - cells[start, 0]
    if down != 0:
        return 0 if down > 0 else 2
    return 1 if cells[end, 1] > cells[start, 1] else 3


@joined
def quarters(before: int, after: int) -> int:
    """Return the number of quarter turns from one direction to another, 0 to 2."""
    apart = abs(before - after)
    return min(apart, DIRECTIONS - apart)


@joined
def least_quarters(cells: Ints, cell: int, heading: int, goal: int) -> int:
    """Return a number of quarter turns that no way of a robot with a heading from a cell to a goal is below.

    It is that of a way without obstacles, and falls by no more than a robot turns.
    """
    down, right = cells[goal, 0] - cells[cell, 0], cells[goal, 1] - cells[cell, 1]
    in_column = quarters(heading, 0 if down > 0 else 2)
    in_row = quarters(heading, 1 if right > 0 else 3)
    if down != 0 and right != 0:
        return int(min(in_column, in_row) + 1)
    return int(in_column if down != 0 else in_row if right != 0 else 0)


@bare
def count_quarters(cells: Ints, path: Ints) -> int:
    """Return the number of quarter turns on a path, which may wait.

    Parameters
    ----------
    cells : (v, 2) int32 array
        Row and column of each cell.
    path : (t,) int32 array
        Cell at each time.
    """
    turns, heading = 0, -1
    for time in range(len(path) - 1):
        if path[time] != path[time + 1]:
            ahead = direction(cells, path[time], path[time + 1])
            if heading >= 0:
                turns += quarters(heading, ahead)
            heading = ahead
    return turns


@bare
def count_all(cells: Ints, paths: Ints, turns: Ints) -> None:
    """Write the number of quarter turns of each of (n, t) ``paths`` into (n,) ``turns``."""
    for robot in range(len(paths)):
        turns[robot] = count_quarters(cells, paths[robot])


def warm() -> None:
    """Compile and call each kernel once."""
    cells = np.array([[0, 0], [0, 1]], np.int32)
    count_all(cells, np.array([[0, 1]], np.int32), np.zeros(1, np.int32))
