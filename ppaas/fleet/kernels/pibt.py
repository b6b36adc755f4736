"""Kernel: one step of all robots by priority inheritance with backtracking (PIBT).

Robots decide in the order of their priorities. A robot takes the free neighbouring cell that is nearest to its goal;
who stands there is pushed away, and decides next with the priority of the one that pushes. If the pushed one finds no
place, the pusher tries its next cell. Source: Okumura et al., "Priority Inheritance with Backtracking for Iterative
Multi-agent Path Finding", Artificial Intelligence 310, 2022.

Closed rings, in which each robot moves into the cell that the next one leaves, are never planned: a robot that waits
until the cell ahead is empty would wait for ever.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.fleet.kernels.areas import count_inside, enter, has_room
from ppaas.fleet.kernels.board import (
    COUNT,
    NOBODY,
    PARTNER,
    Board,
    Ints,
    Step,
    fraction,
    is_barred,
    smallest_board,
    step_of,
)
from ppaas.fleet.kernels.swap import partner
from ppaas.kernel_cache.decorators import bare

SPREAD = np.float32(0.9)
"""Random part of the order of cells [cells]: below 1, so that it only decides between cells of the same distance."""

AHEAD = np.float32(-1.0)
"""Key of the cell to which the robot's guide leads: before all distances."""

DECIDED, FAILED, PUSHES, TRIES = 1, 2, 3, 0
"""State of the robot on top of the stack: it has a place, has none, pushes another one, or has not tried yet."""


@bare
def closes_ring(step: Step, robot: int, cell: int) -> bool:
    """Return whether the move of a robot into a cell closes a ring, or exchanges two robots."""
    other = step.here[cell]
    first = other
    while other >= 0 and other != robot and step.to[other] >= 0 and step.to[other] != step.at[other]:
        other = step.here[step.to[other]]
        if other == first:
            return True
    return bool(other == robot)


@bare
def choose(board: Board, step: Step, robot: int, out: Ints) -> None:
    """Write the cells of a robot into ``out`` from the best to the worst, their number, and its partner (`Step`)."""
    cell, keys = np.int64(step.at[robot]), step.keys
    count = 0
    for k in range(5):
        near = np.int64(board.neighbours[cell, k]) if k < 4 else cell
        if near < 0 or (k < 4 and is_barred(board, robot, near)):
            continue
        key = board.distances[robot, near] + SPREAD * fraction(step.bits)
        if k < 4 and board.guide.shape[0] > 0 and board.guide[robot, cell] == k:
            key = AHEAD
        place = count
        while place > 0 and keys[place - 1] > key:
            keys[place], out[place] = keys[place - 1], out[place - 1]
            place -= 1
        keys[place], out[place] = key, near
        count += 1
    out[COUNT] = count
    out[PARTNER] = partner(board, step, robot, np.int64(out[0]))
    if out[PARTNER] >= 0:  # it is the puller or the pusher of a swap: away from its goal first
        for place in range(count // 2):
            out[place], out[count - 1 - place] = out[count - 1 - place], out[place]


@bare
def is_open(board: Board, step: Step, robot: int, cell: int) -> bool:
    """Return whether nobody has decided for a cell, and a robot may move there without an exchange or a ring."""
    if step.next[cell] >= 0 or not has_room(board, step, robot, cell):
        return False
    other, own = step.here[cell], step.at[robot]
    if other < 0 or other == robot:
        return True
    return step.to[other] != own and (cell == own or not closes_ring(step, robot, cell))


@bare
def advance(board: Board, step: Step, depth: int) -> int:
    """Try the next cells of the robot on top of the stack; return DECIDED, FAILED, or PUSHES with one more on it."""
    robot, mine = np.int64(step.pushed[depth]), step.choices[depth]
    while step.turn[depth] < mine[COUNT]:
        cell = np.int64(mine[step.turn[depth]])
        if not is_open(board, step, robot, cell):
            step.turn[depth] += 1
            continue
        step.next[cell], step.to[robot] = robot, cell
        enter(board, step, robot, cell, 1)
        other = np.int64(step.here[cell])
        if other < 0 or other == robot or step.to[other] >= 0:
            return DECIDED
        step.pushed[depth + 1], step.turn[depth + 1] = other, 0
        choose(board, step, other, step.choices[depth + 1])
        return PUSHES
    step.next[step.at[robot]], step.to[robot] = robot, step.at[robot]
    return FAILED


@bare
def may_move(board: Board, start: int, cell: int) -> bool:
    """Return whether a robot may move from one cell to another."""
    for k in range(4):  # noqa: SIM110 - a kernel has no generators
        if board.neighbours[start, k] == cell:
            return True
    return False


@bare
def pull(board: Board, step: Step, depth: int) -> None:
    """Let the partner of the robot on top of the stack follow into its cell, if both are free to do so."""
    robot, mine = np.int64(step.pushed[depth]), step.choices[depth]
    other, cell = np.int64(mine[PARTNER]), np.int64(step.at[robot])
    if step.turn[depth] > 0 or other < 0 or step.to[other] >= 0 or step.next[cell] >= 0 or step.to[robot] == cell:
        return
    if not may_move(board, np.int64(step.at[other]), cell) or is_barred(board, other, cell):
        return
    if not has_room(board, step, other, cell):
        return
    if not closes_ring(step, other, cell):
        step.to[other], step.next[cell] = cell, other
        enter(board, step, other, cell, 1)


@bare
def place(board: Board, step: Step, robot: int) -> bool:
    """Decide for a robot and all that it pushes away; return False if it must stay and cannot."""
    depth, found = 0, TRIES
    step.pushed[0], step.turn[0] = robot, 0
    choose(board, step, robot, step.choices[0])
    while depth >= 0:
        if found == FAILED:
            last = np.int64(step.pushed[depth])
            enter(board, step, last, np.int64(step.to[last]), -1)
            step.turn[depth] += 1
        if found != DECIDED:
            found = advance(board, step, depth)
        if found == PUSHES:
            depth, found = depth + 1, TRIES
            continue
        if found == DECIDED:
            pull(board, step, depth)
        depth -= 1
    return found == DECIDED


@bare
def decide(board: Board, step: Step, order: NDArray[np.int64]) -> bool:
    """Decide the next cell of each robot.

    Parameters
    ----------
    board, step
        See there. ``step.to`` may hold decisions already; the rest is filled in.
    order : (n,) int64 array
        Robots in the order of their priorities.

    Returns
    -------
    bool
        False if the decisions that were there leave some robot no place.
    """
    for robot in range(len(step.at)):
        step.here[step.at[robot]] = robot
        if step.to[robot] >= 0:
            step.next[step.to[robot]] = robot
    count_inside(board, step)
    decided = True
    for k in range(len(order)):
        if step.to[order[k]] < 0 and not place(board, step, order[k]):
            decided = False
            break
    clear(step)
    return decided


@bare
def is_possible(board: Board, step: Step) -> bool:
    """Return whether the decisions in ``step.to`` have no two robots in one cell, no exchange and no ring.

    Areas that robots enter must have room for all of them.
    """
    count_inside(board, step)
    possible = True
    for robot in range(len(step.at)):
        step.here[step.at[robot]] = robot
    for robot in range(len(step.at)):
        cell = step.to[robot]
        if cell >= 0:
            possible = possible and step.next[cell] < 0
            step.next[cell] = robot
    for robot in range(len(step.at)):
        cell = np.int64(step.to[robot])
        if possible and cell >= 0 and cell != step.at[robot]:
            enter(board, step, robot, cell, -1)  # itself does not count
            possible = has_room(board, step, robot, cell) and not closes_ring(step, robot, cell)
            enter(board, step, robot, cell, 1)
    clear(step)
    return possible


@bare
def clear(step: Step) -> None:
    """Empty ``step.here`` and ``step.next``."""
    for robot in range(len(step.at)):
        step.here[step.at[robot]] = NOBODY
        step.next[step.at[robot]] = NOBODY
        if step.to[robot] >= 0:
            step.next[step.to[robot]] = NOBODY


def warm() -> None:
    """Compile and call each kernel once."""
    board = smallest_board()
    step = step_of(board, np.zeros(1, np.int32), 0)
    decide(board, step, np.zeros(1, np.int64))
    is_possible(board, step)
