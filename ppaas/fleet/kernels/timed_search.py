"""Kernel: the earliest path of one robot among the fixed paths of all others, by A* over cells and times."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.fleet.kernels.board import Ints, below
from ppaas.kernel_cache.decorators import bare

NODES = 40_000
"""Largest number of cells and times that a search visits."""

CELL, TIME, PARENT, NEXT = 0, 1, 2, 3
"""Columns of ``nodes``: cell, time, node before it, and next node of the same bucket."""


class Schedule(NamedTuple):
    """Paths of all robots.

    Parameters
    ----------
    busy : (t, v) int32 array
        Robot in each cell at each time plus 1; 0 is empty.
    paths : (n, t) int32 array
        Cell of each robot at each time.
    arrivals : (n,) int32 array
        Time of the last arrival of each robot at its goal.
    turns : (n,) int32 array
        Number of quarter turns of each robot; 0 if turns cost nothing.
    """

    busy: Ints
    paths: Ints
    arrivals: Ints
    turns: Ints


class Memory(NamedTuple):
    """Memory of searches.

    Parameters
    ----------
    seen : (t, v) int32 array
        Number of the last search that has reached each cell at each time.
    fewest : (t, v, 4) uint8 array
        Fewest quarter turns with which that search was in the cell and had each heading; (0, 0, 4) if turns cost
        nothing.
    nodes : (`NODES`, 4) int32 array
        (`NODES`, 6) if turns cost something (`ppaas.fleet.kernels.turning_search`).
    heads : (c + 2,) int32 array
        First node of each bucket, by the least cost through it, up to c; −1 for none. Without turns, that is the
        earliest arrival.
    kept : (g, t) int32 array
        Paths of a group of robots before they are planned anew.
    group, were, turned : (g,) int32 array
        Robots of the group, and their arrivals and turns before.
    """

    seen: Ints
    fewest: NDArray[np.uint8]
    nodes: Ints
    heads: Ints
    kept: Ints
    group: Ints
    were: Ints
    turned: Ints


@bare
def mark(schedule: Schedule, robot: int, value: int) -> None:
    """Write a value into ``busy`` all along the path of a robot."""
    path = schedule.paths[robot]
    for time in range(len(path)):
        schedule.busy[time, path[time]] = value


@bare
def meets(schedule: Schedule, time: int, cell: int, near: int) -> bool:
    """Return whether a move that begins at a time exchanges two robots, or closes a ring."""
    other = schedule.busy[time, near] - 1
    while other >= 0:
        follows = schedule.paths[other, time + 1]
        if follows == cell:
            return True
        onward = schedule.busy[time, follows] - 1
        if onward == other:
            return False
        other = onward
    return False


@bare
def earliest_stay(schedule: Schedule, goal: int) -> int:
    """Return the time from which nobody crosses a goal any more."""
    time = len(schedule.busy)
    while time > 0 and schedule.busy[time - 1, goal] == 0:
        time -= 1
    return time


@bare
def search(
    neighbours: Ints, distances: NDArray[np.int16], schedule: Schedule, memory: Memory,
    robot: int, start: int, goal: int, limit: int, number: int, bits: NDArray[np.uint64],
) -> int:  # fmt: skip
    """Write the path of a robot that arrives first, and return its arrival.

    Parameters
    ----------
    neighbours : (v, 4) int32 array
    distances : (v,) int16 array
        Distance of each cell from the goal.
    schedule, memory
        See there. ``schedule.busy`` holds the paths of all other robots; the path is written into ``schedule.paths``.
    robot, start, goal : int
    limit : int
        Latest arrival that is of use, less than t.
    number : int
        Number of this search, greater than those before.
    bits : (1,) uint64 array
        Random numbers (`ppaas.fleet.kernels.board`).

    Returns
    -------
    int
        −1 if the robot cannot arrive until ``limit``, or if the search would need too many nodes.
    """
    nodes, heads, busy = memory.nodes, memory.heads, schedule.busy
    stay = earliest_stay(schedule, goal)
    arrival = max(int(distances[start]), stay)
    if arrival > limit:
        return -1
    heads[arrival : limit + 1] = -1
    nodes[0, CELL], nodes[0, TIME], nodes[0, PARENT], nodes[0, NEXT] = start, 0, -1, -1
    heads[arrival] = 0
    used = 1
    while arrival <= limit:
        node = heads[arrival]
        if node < 0:
            arrival += 1
            continue
        heads[arrival] = nodes[node, NEXT]
        cell, time = nodes[node, CELL], nodes[node, TIME]
        if cell == goal and time >= stay:
            write_path(nodes, node, goal, schedule.paths[robot])
            return int(time)
        if time >= limit:
            continue
        turn = below(bits, 4)  # equal paths are of equal use: take any
        for k in range(-1, 4):
            near = cell if k < 0 else neighbours[cell, (k + turn) & 3]
            if near < 0 or busy[time + 1, near] != 0 or memory.seen[time + 1, near] == number:
                continue
            through = max(time + 1 + distances[near], stay)
            if through > limit or (k >= 0 and meets(schedule, time, cell, near)):
                continue
            if used == len(nodes):
                return -1
            memory.seen[time + 1, near] = number
            nodes[used, CELL], nodes[used, TIME], nodes[used, PARENT] = near, time + 1, node
            nodes[used, NEXT] = heads[through]
            heads[through] = used
            used += 1
    return -1


@bare
def write_path(nodes: Ints, node: int, goal: int, path: Ints) -> None:
    """Write the path that ends with a node; afterwards the robot stays at its goal."""
    path[nodes[node, TIME] :] = goal
    while node >= 0:
        path[nodes[node, TIME]] = nodes[node, CELL]
        node = nodes[node, PARENT]
