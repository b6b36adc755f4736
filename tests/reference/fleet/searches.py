"""Slow, obvious twins of searches of fleets: joint, timed and turning ones, with their distances, turns and guides."""

import heapq
import itertools
from collections import Counter
from collections.abc import Iterator, Sequence

from ppaas.fleet.kernels.board import UNREACHABLE
from ppaas.fleet.kernels.guides import MOST_TRAFFIC, STEP
from ppaas.fleet.roadmap import Roadmap

Direction = tuple[int, int]

DIRECTIONS: tuple[Direction, ...] = ((1, 0), (0, 1), (-1, 0), (0, -1))


def direction(roadmap: Roadmap, start: int, end: int) -> Direction:
    """Return by how many rows and columns a move leads."""
    rows, columns = (roadmap.cells[end] - roadmap.cells[start]).tolist()
    return rows, columns


def quarters(before: Direction, after: Direction) -> int:
    """Return the number of quarter turns between two directions, by their scalar product."""
    return 1 - (before[0] * after[0] + before[1] * after[1])


def count(roadmap: Roadmap, path: Sequence[int]) -> int:
    """Return the number of quarter turns on a path."""
    stops = [cell for k, cell in enumerate(path) if k == 0 or cell != path[k - 1]]
    ways = [direction(roadmap, here, there) for here, there in itertools.pairwise(stops)]
    return sum(quarters(one, other) for one, other in itertools.pairwise(ways))


Cells = tuple[int, ...]


def shortest(roadmap: Roadmap, starts: Sequence[int], goals: Sequence[int], sizes: Sequence[int] = ()) -> int | None:
    """Return the least number of steps after which all robots are at their goals; None if they never are.

    Robots of some sizes do not enter the cells that are barred for them.
    """
    wanted, first = tuple(map(int, goals)), tuple(map(int, starts))
    near = [[cell, *(int(one) for one in moves if one >= 0)] for cell, moves in enumerate(roadmap.neighbours)]
    known, layer, steps = {first}, [first], 0
    while layer:
        if wanted in known:
            return steps
        found = {after for before in layer for after in _next(roadmap, near, before, sizes, known)}
        layer, steps = list(found), steps + 1
        known |= found
    return None


def _next(
    roadmap: Roadmap, near: Sequence[Sequence[int]], before: Cells, sizes: Sequence[int], known: set[Cells]
) -> Iterator[Cells]:
    """Yield what one step leads to and is not known; that is asked first, for most of it is."""
    ways = [near[cell] for cell in before]
    for robot, size in enumerate(sizes):
        ways[robot] = [cell for cell in ways[robot] if cell == before[robot] or not roadmap.barred[size, cell]]
    for after in itertools.product(*ways):
        if after in known or len(set(after)) < len(after):
            continue
        if not has_ring(before, after) and has_room(roadmap, before, after):
            yield after


def has_room(roadmap: Roadmap, before: Cells, after: Cells) -> bool:
    """Return whether each area that robots enter has room for them and all that were in it before."""
    for area, room in enumerate(roadmap.room):
        inside = {cell for cell in (*before, *after) if int(roadmap.areas[cell]) >> area & 1}
        entering = sum(there in inside and here not in inside for here, there in zip(before, after, strict=True))
        if entering and entering + sum(here in inside for here in before) > room:
            return False
    return True


def has_ring(before: Cells, after: Cells) -> bool:
    """Return whether robots exchange their cells, two or more in a closed ring."""
    follows = {here: there for here, there in zip(before, after, strict=True) if here != there}
    for first in follows:
        cell = first
        for _ in follows:
            cell = follows.get(cell, -1)
            if cell == first:
                return True
    return False


def distances(roadmap: Roadmap, goal: int) -> list[int]:
    """Return the number of moves from each cell to a goal."""
    found = {goal: 0}
    while True:
        more = {
            cell: 1 + min(found[int(near)] for near in moves if int(near) in found)
            for cell, moves in enumerate(roadmap.neighbours)
            if cell not in found and any(int(near) in found for near in moves)
        }
        if not more:
            return [found.get(cell, int(UNREACHABLE)) for cell in range(len(roadmap))]
        found |= more


class GuidedWays:
    """Ways of robots, each planned among those before it."""

    def __init__(self, roadmap: Roadmap, against: int, crowd: int) -> None:
        self._neighbours = [[int(near) for near in row if near >= 0] for row in roadmap.neighbours]
        self._against, self._crowd = against, crowd
        self._flow: Counter[tuple[int, int]] = Counter()
        self._load: Counter[int] = Counter()

    def cost_of(self, way: Sequence[int]) -> int:
        """Return the cost of a way, a sequence of cells."""
        return sum(self._move(cell, near) for cell, near in itertools.pairwise(way))

    def least_cost(self, start: int, goal: int) -> int | None:
        """Return the cost of the cheapest way, None without one."""
        queue, closed = [(0, start)], set[int]()
        while queue:
            cost, cell = heapq.heappop(queue)
            if cell == goal:
                return cost
            if cell not in closed:
                closed.add(cell)
                for near in self._neighbours[cell]:
                    heapq.heappush(queue, (cost + self._move(cell, near), near))
        return None

    def add(self, way: Sequence[int]) -> None:
        """Add the way of a robot, which makes others dearer."""
        self._load.update(way[1:])
        self._flow.update(itertools.pairwise(way))

    def _move(self, cell: int, near: int) -> int:
        return STEP + min(self._against * self._flow[near, cell] + self._crowd * self._load[near], MOST_TRAFFIC)


def earliest(roadmap: Roadmap, others: Sequence[Sequence[int]], start: int, goal: int) -> int | None:
    """Return the earliest time from which a robot can stay at its goal, among the paths of others; None for never.

    All paths have the same number of steps; the robot may use as many.
    """
    steps = len(others[0])
    stays = [not any(path[late] == goal for path in others for late in range(time, steps)) for time in range(steps)]
    reached = {start}
    for time in range(steps):
        if goal in reached and stays[time]:
            return time
        if time + 1 == steps:
            break
        before, after = [tuple(path[moment] for path in others) for moment in (time, time + 1)]
        reached = {
            near
            for cell in reached
            for near in (cell, *(int(one) for one in roadmap.neighbours[cell] if one >= 0))
            if near not in after and not has_ring((cell, *before), (near, *after))
        }
    return None


def cheapest(
    roadmap: Roadmap, others: Sequence[Sequence[int]], start: int, goal: int, step: int, quarter: int
) -> int | None:
    """Return the least cost of a path to a goal among the paths of others, its turns included; None without a path.

    All paths have the same number of steps; the robot may use as many, and stays at its goal then.
    """
    steps, found = len(others[0]), list[int]()
    reached = {(start, heading): 0 for heading in DIRECTIONS}
    for time in range(steps):
        if not any(path[late] == goal for path in others for late in range(time, steps)):
            found += [step * time + quarter * turned for (cell, _), turned in reached.items() if cell == goal]
        if time + 1 == steps:
            break
        before, after = [tuple(path[moment] for path in others) for moment in (time, time + 1)]
        onward: dict[tuple[int, Direction], int] = {}
        for (cell, heading), turned in reached.items():
            for near in (cell, *(int(one) for one in roadmap.neighbours[cell] if one >= 0)):
                if near in after or has_ring((cell, *before), (near, *after)):
                    continue
                ahead = heading if near == cell else direction(roadmap, cell, near)
                total = turned + quarters(heading, ahead)
                onward[near, ahead] = min(total, onward.get((near, ahead), total))
        reached = onward
    return min(found, default=None)
