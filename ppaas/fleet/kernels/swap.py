"""Kernels: find the pairs of robots that must exchange their places in a lane, and do it at its next junction.

Greedy steps alone never let two robots pass that face each other in a lane. One of the two, the *puller*, goes back to
a junction and the *pusher* follows it, until both can exchange their places there. Source: Okumura, "Improving LaCAM
for Scalable Eventually Optimal Multi-Agent Pathfinding", IJCAI 2023, section 4.
"""

import numpy as np

from ppaas.fleet.kernels.areas import fit_together, has_room
from ppaas.fleet.kernels.board import NOBODY, Board, Ints, Step, is_barred
from ppaas.kernel_cache.decorators import bare, joined

NO_WAY, ONE_WAY, JUNCTION = 0, 1, 2


@joined
def ways_on(board: Board, here: Ints, cell: int, behind: int) -> tuple[int, int]:
    """Return how many ways lead on from a cell, and the last of them.

    Parameters
    ----------
    board : Board
    here : (v,) int32 array
        Robot in each cell.
    cell, behind : int
        The cell, and its neighbour from which one comes.

    Returns
    -------
    ways : int
        `NO_WAY`, `ONE_WAY`, or `JUNCTION` for more. Dead ends in which a robot has arrived do not count.
    last : int
        Cell to which it leads, −1 without one.
    """
    ways, last = NO_WAY, -1
    for k in range(4):
        near = int(board.neighbours[cell, k])
        if near < 0:
            break
        if near == behind:
            continue
        robot = here[near]
        if board.neighbours[near, 1] < 0 and robot >= 0 and board.goals[robot] == near:
            continue
        ways, last = ways + 1, near
    return min(ways, JUNCTION), last


@bare
def is_needed(board: Board, step: Step, pusher: int, puller: int, behind: int, ahead: int) -> bool:
    """Return whether two robots in a lane must exchange their places.

    The kernel moves both on in mind, the puller first, until there is a junction or the lane ends. It ends before an
    area that has no room for both.

    Parameters
    ----------
    board, step
        See there.
    pusher, puller : int
        The robots.
    behind, ahead : int
        Neighbouring cells of the pusher and of the puller.
    """
    distances = board.distances
    while distances[pusher, ahead] < distances[pusher, behind]:
        ways, on = ways_on(board, step.here, ahead, behind)
        if ways == NO_WAY or not fit_together(board, step, pusher, puller, ahead):
            break
        if ways == JUNCTION:
            return False
        behind, ahead = ahead, on
    if distances[puller, behind] >= distances[puller, ahead]:
        return False
    return bool(distances[pusher, behind] == 0 or distances[pusher, ahead] < distances[pusher, behind])


@bare
def is_possible(board: Board, step: Step, pusher: int, puller: int, behind: int, ahead: int) -> bool:
    """Return whether a puller in the cell ``ahead`` reaches a junction when it goes on from ``behind``."""
    first = behind
    for _ in range(len(board.neighbours)):  # where moves are one-way, a ring may not lead back to where it began
        if ahead == first:
            break
        ways, on = ways_on(board, step.here, ahead, behind)
        if ways == NO_WAY or not fit_together(board, step, pusher, puller, ahead):
            return False
        if ways == JUNCTION:
            return True
        behind, ahead = ahead, on
    return False


@bare
def partner(board: Board, step: Step, robot: int, best: int) -> int:
    """Return the robot with which ``robot`` must exchange its place, or −1.

    Parameters
    ----------
    board, step
        See there.
    robot : int
    best : int
        The cell that it wants most.
    """
    cell = np.int64(step.at[robot])
    if best == cell:
        return int(NOBODY)
    other = np.int64(step.here[best])
    if (
        other >= 0
        and step.to[other] < 0
        and not is_barred(board, other, cell)
        and has_room(board, step, other, cell)
        and is_needed(board, step, robot, other, cell, best)
        and is_possible(board, step, other, robot, best, cell)
    ):
        return int(other)
    # Somebody behind the robot may want to pass it, so that it must clear the way: it is the puller.
    for k in range(4):
        near = np.int64(board.neighbours[cell, k])
        if near < 0:
            break
        other = np.int64(step.here[near])
        if (
            other >= 0
            and near != best
            and not is_barred(board, other, cell)
            and has_room(board, step, other, cell)
            and is_needed(board, step, other, robot, cell, best)
            and is_possible(board, step, other, robot, best, cell)
        ):
            return int(other)
    return int(NOBODY)
