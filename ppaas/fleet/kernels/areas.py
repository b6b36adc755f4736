"""Kernel: areas that have room for few robots.

Areas are bits of each cell (`Board.areas`). A robot enters an area with a move from a cell outside of it.
"""

import numpy as np

from ppaas.fleet.kernels.board import Board, Step, smallest_board, step_of
from ppaas.kernel_cache.decorators import bare


@bare
def enter(board: Board, step: Step, robot: int, cell: int, number: int) -> None:
    """Count a robot as one that enters the areas of a cell, or with −1 as ``number``, as one that does not after all.

    A robot that leaves an area makes room in it only after the step: otherwise one that waits until there is room might
    wait for itself.
    """
    if len(board.room) > 0:
        entered = board.areas[cell] & ~board.areas[step.at[robot]]
        for area in range(len(board.room)):
            if entered >> np.uint64(area) & np.uint64(1):
                step.inside[area] += number


@bare
def has_room(board: Board, step: Step, robot: int, cell: int) -> bool:
    """Return whether there is room for a robot in the areas of a cell that it is not in."""
    if len(board.room) > 0:
        entered = board.areas[cell] & ~board.areas[step.at[robot]]
        for area in range(len(board.room)):
            if entered >> np.uint64(area) & np.uint64(1) and step.inside[area] >= board.room[area]:
                return False
    return True


@bare
def fit_together(board: Board, step: Step, one: int, other: int, cell: int) -> bool:
    """Return whether there is room for two robots together in the areas of a cell, beside all others."""
    for area in range(len(board.room)):
        bit = np.uint64(1) << np.uint64(area)
        if board.areas[cell] & bit:
            inside = step.inside[area]
            inside -= np.int32((board.areas[step.at[one]] & bit) != 0) + np.int32(
                (board.areas[step.at[other]] & bit) != 0
            )
            if inside + 2 > board.room[area]:
                return False
    return True


@bare
def count_inside(board: Board, step: Step) -> None:
    """Count the robots in each area before the step, and those whose decisions are in ``step.to`` already."""
    for area in range(len(board.room)):
        step.inside[area] = 0
        for robot in range(len(step.at)):
            step.inside[area] += np.int32(board.areas[step.at[robot]] >> np.uint64(area) & np.uint64(1))
    if len(board.room) > 0:
        for robot in range(len(step.at)):
            if step.to[robot] >= 0:
                enter(board, step, robot, np.int64(step.to[robot]), 1)


def warm() -> None:
    """Compile and call each kernel once."""
    board = smallest_board()
    step = step_of(board, np.zeros(1, np.int32), 0)
    count_inside(board, step)
    has_room(board, step, 0, 1)
    fit_together(board, step, 0, 0, 1)
