"""Kernel: improve a plan by large neighbourhood search.

A few robots that are in each other's way are taken out, and planned anew one after the other among the fixed paths of
all others. Their new paths are kept unless the sum of their arrivals has grown. Source: Li et al., "Anytime Multi-Agent
Path Finding via Large Neighborhood Search", IJCAI 2021; groups as its agent-based neighbourhoods.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.fleet.kernels.board import Board, Ints, below, seeded, shuffle, smallest_board
from ppaas.fleet.kernels.timed_search import NODES, Memory, Schedule, mark, search
from ppaas.planners.kernels.jit_decorators import bare

WALKS = 8
"""Number of random walks that look for robots in the way of another one."""


@bare
def gather(board: Board, schedule: Schedule, first: int, group: Ints, bits: NDArray[np.uint64]) -> int:
    """Write a robot and those in its way into ``group``; return their number.

    Robots in its way are met on random walks that leave its path at a random time, and along which it would still
    arrive earlier than it does.
    """
    group[0] = first
    count, arrival = 1, int(schedule.arrivals[first])
    for _ in range(WALKS):
        time = below(bits, max(arrival, 1))
        cell = int(schedule.paths[first, time])
        while count < len(group) and time + 1 < len(schedule.busy):
            onward, turn = -1, below(bits, 5)
            for k in range(5):
                move = (k + turn) % 5
                near = int(board.neighbours[cell, move]) if move < 4 else cell
                if near >= 0 and time + 1 + board.distances[first, near] < arrival:
                    onward = near
                    break
            if onward < 0:
                break
            time, cell = time + 1, onward
            other = schedule.busy[time, cell] - 1
            if other >= 0 and not holds(group, count, other):
                group[count] = other
                count += 1
        if count == len(group):
            break
    return count


@bare
def holds(group: Ints, count: int, robot: int) -> bool:
    """Return whether a robot is one of the first ``count`` of a group."""
    for k in range(count):  # noqa: SIM110 - a kernel has no generators
        if group[k] == robot:
            return True
    return False


@bare
def copy(path: Ints, out: Ints) -> None:
    """Copy a path; an assignment of a slice might allocate memory."""
    for time in range(len(path)):
        out[time] = path[time]


@bare
def replan(
    board: Board, starts: Ints, schedule: Schedule, memory: Memory, count: int, number: int, bits: NDArray[np.uint64]
) -> int:
    """Plan the robots of ``memory.group`` anew; return by how much the sum of their arrivals has fallen.

    Parameters
    ----------
    board, schedule, memory
        See there.
    starts : (n,) int32 array
    count : int
        Number of robots in the group.
    number : int
        Number of the first search; ``count`` searches have the next numbers.
    bits : (1,) uint64 array
    """
    group = memory.group
    before, rest = 0, 0  # sum of arrivals, and of the least possible arrivals of those that are not planned yet
    for k in range(count):
        robot = group[k]
        copy(schedule.paths[robot], memory.kept[k])
        memory.were[k] = schedule.arrivals[robot]
        before += schedule.arrivals[robot]
        rest += board.distances[robot, starts[robot]]
        mark(schedule, robot, 0)
    after, done = 0, 0
    for k in range(count):
        robot = group[k]
        rest -= board.distances[robot, starts[robot]]
        limit = min(before - after - rest, len(schedule.busy) - 1)
        arrival = search(
            board.neighbours, board.distances[robot], schedule, memory,
            robot, starts[robot], board.goals[robot], limit, number + k, bits,
        )  # fmt: skip
        if arrival < 0:
            break
        after += arrival
        schedule.arrivals[robot] = arrival
        mark(schedule, robot, robot + 1)
        done += 1
    if done == count:
        return int(before - after)
    for k in range(done):
        mark(schedule, group[k], 0)
    for k in range(count):
        robot = group[k]
        copy(memory.kept[k], schedule.paths[robot])
        schedule.arrivals[robot] = memory.were[k]
        mark(schedule, robot, robot + 1)
    return 0


@bare
def improve_some(
    board: Board, starts: Ints, schedule: Schedule, memory: Memory, firsts: Ints, alone: bool, number: int,
    bits: NDArray[np.uint64],
) -> int:  # fmt: skip
    """Try to improve the paths of some robots, each with those in its way, or ``alone``.

    Parameters
    ----------
    board, schedule, memory
        See there.
    starts : (n,) int32 array
    firsts : (m,) int32 array
        The robots.
    alone : bool
    number : int
        Number of the first search; m times the largest size of a group have the next numbers.
    bits : (1,) uint64 array

    Returns
    -------
    int
        By how much the sum of all arrivals has fallen.
    """
    gain = 0
    for k in range(len(firsts)):
        count = 1
        memory.group[0] = firsts[k]
        if not alone:
            count = gather(board, schedule, firsts[k], memory.group, bits)
            shuffle(bits, memory.group[:count])
        gain += replan(board, starts, schedule, memory, count, number + k * len(memory.group), bits)
    return gain


def memory_of(steps: int, cells: int, group: int) -> Memory:
    """Return the memory for paths of a number of steps, and groups of a number of robots."""
    return Memory(
        np.zeros((steps, cells), np.int32),
        np.empty((NODES, 4), np.int32),
        np.empty(steps + 1, np.int32),
        np.empty((group, steps), np.int32),
        np.empty(group, np.int32),
        np.empty(group, np.int32),
    )


def warm() -> None:
    """Compile and call each kernel once."""
    schedule = Schedule(np.array([[1, 0], [0, 1]], np.int32), np.array([[0, 1]], np.int32), np.ones(1, np.int32))
    robots = np.zeros(1, np.int32)
    improve_some(smallest_board(), robots, schedule, memory_of(2, 2, 2), robots, False, 1, seeded(0))
