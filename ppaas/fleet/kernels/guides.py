"""Kernel: guides, ways of single robots that avoid each other's traffic.

The way of each robot is planned by A* over costs that the ways of those before it make: moves against their stream and
cells that many of them cross are dearer. `pibt.choose` prefers the guide of a robot to all other cells, so robots form
lanes. Planning all ways anew once more takes as long again, and shortens no plan. Idea: Chen et al., "Traffic Flow
Optimisation for Lifelong Multi-Agent Path Finding", AAAI 2024.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.fleet.kernels.board import Board, Ints, smallest_board
from ppaas.kernel_cache.decorators import bare

STEP = 10
"""Cost of a move without traffic."""

MOST_TRAFFIC = 400
"""Greatest cost of the traffic of one move."""

BUCKETS = 16_384
"""Number of buckets of the queue: a way may cost so much more than one without traffic."""

ENTRIES = 6
"""Queue entries for each cell."""

LOAD, MARK, COST, CAME = range(4)
"""Columns of `Traffic.cells`."""


class Traffic(NamedTuple):
    """Numbers of the ways of all robots through each cell, and the memory of a search.

    Parameters
    ----------
    back : (v, 4) int8 array
        Index of a cell among the neighbours of its neighbour: ``neighbours[neighbours[c, k], back[c, k]] = c``; −1
        where no robot may move back.
    against : (v, 4) int32 array
        Number of ways that come towards each move from a cell to its neighbour.
    cells : (v, 4) int32 array
        What a search looks up of each neighbour, side by side in the cache: `LOAD`, the number of ways that lead into
        the cell; `MARK`, twice the number of the last search that reached it, and one more once that expanded it;
        valid for that search, `COST`, the least cost of the cell, and `CAME`, the cell before it, times 4, and the
        index of the move.
    heads : (BUCKETS,) int32 array
        First entry of each bucket, −1 for none.
    entries : (ENTRIES·v, 2) int32 array
        Cell, and next entry of the same bucket.
    """

    back: NDArray[np.int8]
    against: Ints
    cells: Ints
    heads: Ints
    entries: Ints


@bare
def find_back(neighbours: Ints, back: NDArray[np.int8]) -> None:
    """Fill in `Traffic.back`."""
    for cell in range(len(neighbours)):
        for k in range(4):
            near = neighbours[cell, k]
            back[cell, k] = -1
            for other in range(4):
                if near >= 0 and neighbours[near, other] == cell:
                    back[cell, k] = other


@bare
def put_in(board: Board, traffic: Traffic, robot: int, start: int) -> None:
    """Add the way of a robot that `search` has found."""
    cell, guide = board.goals[robot], board.guide[robot]
    while cell != start:
        before, k = traffic.cells[cell, CAME] >> 2, traffic.cells[cell, CAME] & 3
        guide[before] = k
        back = traffic.back[before, k]
        if back >= 0:
            traffic.against[cell, back] += 1
        traffic.cells[cell, LOAD] += 1
        cell = before


@bare
def search(board: Board, traffic: Traffic, robot: int, start: int, against: int, crowd: int, number: int) -> bool:
    """Find the cheapest way of a robot by A*; return whether there is one within the buckets.

    Parameters
    ----------
    board, traffic
        See there.
    robot, start : int
        The robot and its cell.
    against, crowd : int
        Cost of each way in the opposite direction of a move, and of each way through its cell; 10 is a free move.
    number : int
        Number of this search, greater than those before.
    """
    distances, goal = board.distances[robot], board.goals[robot]
    heads, entries, cells = traffic.heads, traffic.entries, traffic.cells
    heads[:] = -1
    least = STEP * distances[start]
    reached, expanded = 2 * number, 2 * number + 1
    cells[start, COST], cells[start, MARK] = 0, reached
    entries[0, 0], entries[0, 1] = start, -1
    heads[0] = 0
    used, bucket = 1, 0
    while bucket < BUCKETS:
        entry = heads[bucket]
        if entry < 0:
            bucket += 1
            continue
        heads[bucket] = entries[entry, 1]
        cell = entries[entry, 0]
        if cells[cell, MARK] == expanded:
            continue
        cells[cell, MARK] = expanded
        if cell == goal:
            return True
        so_far = cells[cell, COST] + STEP
        for k in range(4):
            near = board.neighbours[cell, k]
            if near < 0:
                break
            mark = cells[near, MARK]
            if mark == expanded:
                continue
            met = crowd * cells[near, LOAD] + against * traffic.against[cell, k]
            cost = so_far + min(met, MOST_TRAFFIC)
            if mark == reached and cost >= cells[near, COST]:
                continue
            cells[near, COST], cells[near, MARK], cells[near, CAME] = cost, reached, 4 * cell + k
            place = cost + STEP * distances[near] - least
            if place < BUCKETS and used < len(entries):
                entries[used, 0], entries[used, 1] = near, heads[place]
                heads[place] = used
                used += 1
    return False


@bare
def guide_some(
    board: Board, traffic: Traffic, starts: Ints, robots: Ints, against: int, crowd: int, number: int
) -> None:
    """Plan the ways of some robots, which have none yet.

    Parameters
    ----------
    board, traffic
        See there. ``board.guide`` is in and out; a robot without a way within the buckets gets none.
    starts : (n,) int32 array
    robots : (m,) int32 array
        The robots, in the order in which they are planned.
    against, crowd, number : int
        As in `search`; the searches are numbered from ``number``.
    """
    for k in range(len(robots)):
        robot = robots[k]
        if search(board, traffic, robot, starts[robot], against, crowd, number + k):
            put_in(board, traffic, robot, starts[robot])


def traffic_of(neighbours: Ints) -> Traffic:
    """Return the arrays for robots without ways."""
    cells = len(neighbours)
    back = np.empty((cells, 4), np.int8)
    find_back(neighbours, back)
    return Traffic(
        back,
        against=np.zeros((cells, 4), np.int32),
        cells=np.zeros((cells, 4), np.int32),
        heads=np.empty(BUCKETS, np.int32),
        entries=np.empty((ENTRIES * cells, 2), np.int32),
    )


def warm() -> None:
    """Compile and call each kernel once."""
    board = smallest_board(np.full((1, 2), -1, np.int8))
    robots = np.zeros(1, np.int32)
    guide_some(board, traffic_of(board.neighbours), np.zeros(1, np.int32), robots, 5, 1, 1)
