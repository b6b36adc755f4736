"""Kernel: distances of all cells from a goal, by breadth-first search."""

import numpy as np
from numpy.typing import NDArray

from ppaas.fleet.kernels.board import UNREACHABLE, Ints, smallest_board
from ppaas.kernel_cache.decorators import bare


@bare
def flood(incoming: Ints, goal: int, distances: NDArray[np.int16], queue: Ints) -> bool:
    """Compute the distance of each cell from a goal.

    Parameters
    ----------
    incoming : (v, 4) int32 array
        Cells from which a robot may move into each cell, −1 behind the last one.
    goal : int
    distances : (v,) int16 array
        Distances [cells], `UNREACHABLE` without a way. Out.
    queue : (v,) int32 array
        Scratch memory.

    Returns
    -------
    bool
        False if a distance does not fit into the table.
    """
    distances[:] = UNREACHABLE
    distances[goal] = 0
    queue[0] = goal
    first, end = 0, 1
    while first < end:
        cell = queue[first]
        first += 1
        distance = distances[cell] + np.int16(1)
        for k in range(4):
            near = incoming[cell, k]
            if near < 0:
                break
            if distances[near] == UNREACHABLE:
                if distance == UNREACHABLE:
                    return False
                distances[near] = distance
                queue[end] = near
                end += 1
    return True


@bare
def flood_all(incoming: Ints, goals: Ints, distances: NDArray[np.int16], queue: Ints) -> bool:
    """Fill a row of ``distances`` for each goal; return False if a distance does not fit into the table."""
    for row in range(len(goals)):  # noqa: SIM110 - a kernel has no generators
        if not flood(incoming, goals[row], distances[row], queue):
            return False
    return True


def warm() -> None:
    """Compile and call each kernel once."""
    flood_all(smallest_board().neighbours, np.zeros(1, np.int32), np.empty((1, 2), np.int16), np.empty(2, np.int32))
