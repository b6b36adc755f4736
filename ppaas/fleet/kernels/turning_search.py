"""Kernel: the cheapest path of one robot among the fixed paths of all others, where turns cost something, too.

As `timed_search`, by A* over cells and times, and here over headings as well: a robot turns towards a cell before it
moves there. The cost of a path is its arrival, and its quarter turns.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.fleet.kernels.board import Ints, below
from ppaas.fleet.kernels.timed_search import (
    CELL,
    NEXT,
    PARENT,
    TIME,
    Memory,
    Schedule,
    earliest_stay,
    meets,
    write_path,
)
from ppaas.fleet.kernels.turns import DIRECTIONS, direction, least_quarters, quarters
from ppaas.kernel_cache.decorators import bare

HEADING, QUARTERS, COLUMNS = 4, 5, 6
"""Further columns of ``nodes``: direction of the last move, and quarter turns up to the node; number of columns."""

MOST_QUARTERS = 250
"""Largest number of quarter turns of a path that is found."""


class Prices(NamedTuple):
    """Costs of paths.

    Parameters
    ----------
    step, quarter : int
        Cost of a step and of a quarter turn. If that is 0, a step costs 1.
    least : (n,) int64 array
        A cost that no path of each robot is below.
    cells : (v, 2) int32 array
        Row and column of each cell.
    """

    step: int
    quarter: int
    least: NDArray[np.int64]
    cells: Ints


@bare
def is_beaten(memory: Memory, number: int, time: int, cell: int, heading: int, turned: int) -> bool:
    """Return whether a search has been in a cell at a time, and had a heading there with as few quarter turns."""
    return bool(memory.seen[time, cell] == number and memory.fewest[time, cell, heading] <= turned)


@bare
def note(memory: Memory, number: int, time: int, cell: int, heading: int, turned: int) -> None:
    """Note that a search expands a cell with a heading and quarter turns, from which it may turn on the spot."""
    fewest = memory.fewest[time, cell]
    for other in range(DIRECTIONS):
        total = turned + quarters(heading, other)
        if memory.seen[time, cell] != number or total < fewest[other]:
            fewest[other] = total
    memory.seen[time, cell] = number


@bare
def push(nodes: Ints, heads: Ints, used: int, bucket: int, node: tuple[int, int, int, int, int]) -> None:
    """Write a node of cell, time, parent, heading and quarter turns, and put it into a bucket."""
    nodes[used, CELL], nodes[used, TIME], nodes[used, PARENT], nodes[used, HEADING], nodes[used, QUARTERS] = node
    nodes[used, NEXT] = heads[bucket]
    heads[bucket] = used


@bare
def search_turning(
    neighbours: Ints, distances: NDArray[np.int16], schedule: Schedule, memory: Memory, prices: Prices,
    robot: int, start: int, goal: int, limit: int, number: int, bits: NDArray[np.uint64],
) -> int:  # fmt: skip
    """Write the path of a robot that costs least, and return its cost.

    Parameters
    ----------
    neighbours : (v, 4) int32 array
    distances : (v,) int16 array
        Distance of each cell from the goal.
    schedule, memory, prices
        See there. ``schedule.busy`` holds the paths of all other robots; the path is written into ``schedule.paths``.
    robot, start, goal : int
    limit : int
        Greatest cost that is of use, less than the number of ``memory.heads``.
    number : int
        Number of this search, greater than those before.
    bits : (1,) uint64 array
        Random numbers (`ppaas.fleet.kernels.board`).

    Returns
    -------
    int
        −1 if no path costs up to ``limit``, or if the search would need too many nodes.
    """
    nodes, heads, busy = memory.nodes, memory.heads, schedule.busy
    stay = earliest_stay(schedule, goal)
    bucket = prices.step * max(int(distances[start]), stay)
    if bucket > limit or stay >= len(busy):
        return -1
    heads[bucket : limit + 1] = -1
    used = 0
    for heading in range(DIRECTIONS):  # the first one is free
        cost = bucket + prices.quarter * least_quarters(prices.cells, start, heading, goal)
        if cost <= limit:
            push(nodes, heads, used, cost, (start, 0, -1, heading, 0))
            used += 1
    while bucket <= limit:
        node = heads[bucket]
        if node < 0:
            bucket += 1
            continue
        heads[bucket] = nodes[node, NEXT]
        cell, time, heading, turns = nodes[node, CELL], nodes[node, TIME], nodes[node, HEADING], nodes[node, QUARTERS]
        if is_beaten(memory, number, time, cell, heading, turns):
            continue
        note(memory, number, time, cell, heading, turns)
        if cell == goal and time >= stay:
            write_path(nodes, node, goal, schedule.paths[robot])
            return int(bucket)
        if time + 1 == len(busy):
            continue
        turn = below(bits, 4)  # equal paths are of equal use: take any
        for k in range(-1, 4):
            near = cell if k < 0 else neighbours[cell, (k + turn) & 3]
            if near < 0 or busy[time + 1, near] != 0:
                continue
            ahead = heading if k < 0 else direction(prices.cells, cell, near)
            turned = turns + quarters(heading, ahead)
            through = prices.step * max(time + 1 + distances[near], stay)
            through += prices.quarter * (turned + least_quarters(prices.cells, near, ahead, goal))
            if through > limit or turned > MOST_QUARTERS:
                continue
            if is_beaten(memory, number, time + 1, near, ahead, turned):
                continue
            if k >= 0 and meets(schedule, time, cell, near):
                continue
            if used == len(nodes):
                return -1
            push(nodes, heads, used, through, (near, time + 1, node, ahead, turned))
            used += 1
    return -1
