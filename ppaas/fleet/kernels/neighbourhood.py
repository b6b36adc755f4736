"""Kernel: improve a plan by large neighbourhood search.

A few robots that are in each other's way are taken out, and planned anew one after the other among the fixed paths of
all others. Their new paths are kept unless the sum of their costs has grown: arrivals, and turns if these cost
something. Source: Li et al., "Anytime Multi-Agent Path Finding via Large Neighborhood Search", IJCAI 2021; groups as
its agent-based neighbourhoods.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.fleet.kernels.board import Board, Ints, below, seeded, shuffle, smallest_board
from ppaas.fleet.kernels.timed_search import NEXT, NODES, Memory, Schedule, mark, search
from ppaas.fleet.kernels.turning_search import COLUMNS, Prices, search_turning
from ppaas.fleet.kernels.turns import DIRECTIONS, count_quarters
from ppaas.kernel_cache.decorators import bare, joined

WALKS = 8
"""Number of random walks that look for robots in the way of another one."""


@joined
def cost_of(schedule: Schedule, prices: Prices, robot: int) -> int:
    """Return the cost of the path of a robot."""
    return int(prices.step * schedule.arrivals[robot] + prices.quarter * schedule.turns[robot])


@bare
def gather(board: Board, schedule: Schedule, prices: Prices, first: int, group: Ints, bits: NDArray[np.uint64]) -> int:
    """Write a robot and those in its way into ``group``; return their number.

    Robots in its way are met on random walks that leave its path at a random time, and along which it would still
    arrive earlier than it does. If turns cost something, it may arrive as much later as it spends on turns beyond the
    least.
    """
    group[0] = first
    more = (cost_of(schedule, prices, first) - prices.least[first]) // prices.step
    count, until = 1, int(board.distances[first, schedule.paths[first, 0]] + more)
    for _ in range(WALKS):
        time = below(bits, max(schedule.arrivals[first], 1))
        cell = int(schedule.paths[first, time])
        while count < len(group) and time + 1 < len(schedule.busy):
            onward, turn = -1, below(bits, 5)
            for k in range(5):
                move = (k + turn) % 5
                near = int(board.neighbours[cell, move]) if move < 4 else cell
                if near >= 0 and time + 1 + board.distances[first, near] < until:
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
def plan_one(
    board: Board, start: int, schedule: Schedule, memory: Memory, prices: Prices,
    robot: int, limit: int, number: int, bits: NDArray[np.uint64],
) -> int:  # fmt: skip
    """Plan a robot anew among all others, and mark its path; return its cost, −1 if it has no path (`search`)."""
    distances, goal = board.distances[robot], board.goals[robot]
    if prices.quarter == 0:
        cost = search(board.neighbours, distances, schedule, memory, robot, start, goal, limit, number, bits)
    else:
        cost = search_turning(
            board.neighbours, distances, schedule, memory, prices, robot, start, goal, limit, number, bits
        )
    if cost >= 0:
        if prices.quarter > 0:
            schedule.turns[robot] = count_quarters(prices.cells, schedule.paths[robot])
        schedule.arrivals[robot] = (cost - prices.quarter * schedule.turns[robot]) // prices.step
        mark(schedule, robot, robot + 1)
    return int(cost)


@bare
def replan(
    board: Board, starts: Ints, schedule: Schedule, memory: Memory, prices: Prices,
    count: int, number: int, bits: NDArray[np.uint64],
) -> int:  # fmt: skip
    """Plan the robots of ``memory.group`` anew; return by how much the sum of their costs has fallen.

    Parameters
    ----------
    board, schedule, memory, prices
        See there.
    starts : (n,) int32 array
    count : int
        Number of robots in the group.
    number : int
        Number of the first search; ``count`` searches have the next numbers.
    bits : (1,) uint64 array
    """
    group = memory.group
    before, rest = 0, 0  # sum of costs, and of the least possible costs of those that are not planned yet
    for k in range(count):
        robot = group[k]
        copy(schedule.paths[robot], memory.kept[k])
        memory.were[k], memory.turned[k] = schedule.arrivals[robot], schedule.turns[robot]
        before += cost_of(schedule, prices, robot)
        rest += prices.least[robot]
        mark(schedule, robot, 0)
    after, done = 0, 0
    for k in range(count):
        robot = group[k]
        rest -= prices.least[robot]
        limit = min(before - after - rest, len(memory.heads) - 2)
        cost = plan_one(board, starts[robot], schedule, memory, prices, robot, limit, number + k, bits)
        if cost < 0:
            break
        after += cost
        done += 1
    if done == count:
        return int(before - after)
    for k in range(done):
        mark(schedule, group[k], 0)
    for k in range(count):
        robot = group[k]
        copy(memory.kept[k], schedule.paths[robot])
        schedule.arrivals[robot], schedule.turns[robot] = memory.were[k], memory.turned[k]
        mark(schedule, robot, robot + 1)
    return 0


@bare
def improve_some(
    board: Board, starts: Ints, schedule: Schedule, memory: Memory, prices: Prices, firsts: Ints, alone: bool,
    number: int, bits: NDArray[np.uint64],
) -> int:  # fmt: skip
    """Try to improve the paths of some robots, each with those in its way, or ``alone``.

    Parameters
    ----------
    board, schedule, memory, prices
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
        By how much the sum of all costs has fallen.
    """
    gain = 0
    for k in range(len(firsts)):
        count = 1
        memory.group[0] = firsts[k]
        if not alone:
            count = gather(board, schedule, prices, firsts[k], memory.group, bits)
            shuffle(bits, memory.group[:count])
        gain += replan(board, starts, schedule, memory, prices, count, number + k * len(memory.group), bits)
    return gain


def memory_of(steps: int, cells: int, group: int, prices: Prices) -> Memory:
    """Return the memory for paths of a number of steps, and groups of a number of robots."""
    turning = prices.quarter > 0
    most = (steps - 1) * (prices.step + 2 * prices.quarter)
    return Memory(
        np.zeros((steps, cells), np.int32),
        np.empty((steps, cells, DIRECTIONS) if turning else (0, 0, DIRECTIONS), np.uint8),
        np.empty((NODES, COLUMNS if turning else NEXT + 1), np.int32),
        np.empty(most + 2, np.int32),
        np.empty((group, steps), np.int32),
        np.empty(group, np.int32),
        np.empty(group, np.int32),
        np.empty(group, np.int32),
    )


def warm() -> None:
    """Compile and call each kernel once."""
    busy, paths, one = np.array([[1, 0], [0, 1]], np.int32), np.array([[0, 1]], np.int32), np.ones(1, np.int32)
    schedule = Schedule(busy, paths, one, np.zeros(1, np.int32))
    prices = Prices(1, 0, np.ones(1, np.int64), np.array([[0, 0], [0, 1]], np.int32))
    robots, memory = np.zeros(1, np.int32), memory_of(2, 2, 2, prices)
    improve_some(smallest_board(), robots, schedule, memory, prices, robots, False, 1, seeded(0))
