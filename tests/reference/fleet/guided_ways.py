"""Slow twin of `ppaas.fleet.kernels.guides`: counts of ways in dictionaries, and Dijkstra's algorithm with a heap."""

import heapq
import itertools
from collections import Counter
from collections.abc import Sequence

from ppaas.fleet.kernels.guides import MOST_TRAFFIC, STEP
from ppaas.fleet.roadmap import Roadmap


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
