"""Kernel: steps of robots that get a new goal each time that they have reached one."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.fleet.kernels.board import Board, Step, step_of
from ppaas.fleet.kernels.pibt import decide


@njit(cache=True, nogil=True, error_model="numpy")
def advance(board: Board, step: Step, ages: NDArray[np.float32]) -> bool:
    """Decide the next cell of each robot, the one whose goal is open for the longest time first.

    Parameters
    ----------
    board, step
        See there. ``step.at`` holds the cells; the next ones are written into ``step.to``.
    ages : (n,) float32 array
        Number of steps for which the goal of each robot has been open; its fraction decides between equal ones. In and
        out.

    Returns
    -------
    bool
        True; `decide` always finds a step, since all robots may wait.
    """
    for robot in range(len(ages)):
        away = step.at[robot] != board.goals[robot]
        ages[robot] = ages[robot] + np.float32(1) if away else ages[robot] - np.floor(ages[robot])
    step.to[:] = -1
    return bool(decide(board, step, np.argsort(-ages)))


def warm() -> None:
    """Compile and call each kernel once."""
    neighbours = np.array([[1, -1, -1, -1], [0, -1, -1, -1]], np.int32)
    board = Board(neighbours, np.array([[1, 0]], np.int16), np.empty((0, 0), np.int8), np.ones(1, np.int32))
    advance(board, step_of(2, np.zeros(1, np.int32), 0), np.zeros(1, np.float32))
