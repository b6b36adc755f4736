"""A custom planner: greedy best-first search (Pearl, 1984), which expands the cell that looks nearest to the goal."""

import heapq
import math
from collections.abc import Callable, Iterator
from typing import ClassVar

import numpy as np

from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidParameter
from ppaas.planners.ends import Cell, Ends
from ppaas.planners.grid_planner import Found, GridPlanner
from ppaas.planners.traits import Traits
from ppaas.planners.weights import passable

MOVES = ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, -1), (-1, 1))


class Greedy(GridPlanner):
    """Greedy best-first search: expands few cells in open space, but the path may be far from the shortest.

    Parameters
    ----------
    allow_unknown : bool
        Whether paths may lead through unknown cells.
    caution : float
        Penalty of a cell of cost 100: it ranks like a free cell that is so much farther from the goal [cells].
    """

    name: ClassVar[str] = "greedy"
    purpose: ClassVar[str] = "Any path, quickly, in open space."
    traits: ClassVar[Traits] = Traits()

    def __init__(self, *, allow_unknown: bool = True, caution: float = 1.0) -> None:
        super().__init__(allow_unknown=allow_unknown)
        self._open = passable(allow_unknown)
        if not 0.0 <= caution < math.inf:
            raise InvalidParameter(f"caution must be a finite number of cells, 0 or more, not {caution}")
        self.caution = caution

    # GridPlanner determines the start and goal cells, and computes poses and cost from the cells returned here.
    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Return the cells of a path from start to goal; an empty array if there is none."""
        came_from: dict[Cell, Cell] = {ends.start: ends.start}
        queue = [(0.0, ends.start)]
        while queue:
            check()  # raises if the request was cancelled or timed out
            _, cell = heapq.heappop(queue)
            if cell == ends.goal:
                return Found(np.array(_path_to(came_from, cell), np.int32), len(came_from))
            for neighbour in self._neighbours(costmap, cell):
                if neighbour not in came_from:
                    came_from[neighbour] = cell
                    distance = math.dist(neighbour, ends.goal)
                    heapq.heappush(queue, (distance + self.caution * int(costmap.data[neighbour]) / 100.0, neighbour))
        return Found(np.empty((0, 2), np.int32), len(came_from))

    def _neighbours(self, costmap: Costmap, cell: Cell) -> Iterator[Cell]:
        row, column = cell
        for down, right in MOVES:
            # A diagonal move must not cut corners: both adjacent cells must be free too.
            touched = (row + down, column), (row, column + right), (row + down, column + right)
            if all(self._free(costmap, each) for each in touched):
                yield touched[-1]

    def _free(self, costmap: Costmap, cell: Cell) -> bool:
        inside = 0 <= cell[0] < costmap.info.height and 0 <= cell[1] < costmap.info.width
        return inside and bool(self._open[costmap.data[cell]])


def _path_to(came_from: dict[Cell, Cell], cell: Cell) -> list[Cell]:
    path = [cell]
    while came_from[cell] != cell:
        cell = came_from[cell]
        path.append(cell)
    return path[::-1]
