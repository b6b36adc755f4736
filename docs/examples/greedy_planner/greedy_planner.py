"""A planner of one's own: greedy best-first search (Pearl, 1984), which always goes on where the goal looks nearest."""

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
    """Looks at few cells in the open; what it finds may be a long way round.

    Parameters
    ----------
    allow_unknown : bool
        Whether paths may lead through unknown cells.
    caution : float
        How many cells nearer to the goal a cell must be to make up for a cost of 100.
    """

    name: ClassVar[str] = "greedy"
    purpose: ClassVar[str] = "Some path, soon, in the open."
    traits: ClassVar[Traits] = Traits()

    def __init__(self, *, allow_unknown: bool = True, caution: float = 1.0) -> None:
        super().__init__(allow_unknown=allow_unknown)
        self._open = passable(allow_unknown)
        if not 0.0 <= caution < math.inf:
            raise InvalidParameter(f"caution must be a number of cells from 0 up, not {caution}")
        self.caution = caution

    # GridPlanner has found the cells of start and goal, and makes poses and costs of the cells that are returned here.
    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Find the cells between two ends; none if there is no way."""
        came: dict[Cell, Cell] = {ends.start: ends.start}
        queue = [(0.0, ends.start)]
        while queue:
            check()  # raises when the request is cancelled or its time is up
            _, cell = heapq.heappop(queue)
            if cell == ends.goal:
                return Found(np.array(_way(came, cell), np.int32), len(came))
            for neighbour in self._neighbours(costmap, cell):
                if neighbour not in came:
                    came[neighbour] = cell
                    left = math.dist(neighbour, ends.goal)
                    heapq.heappush(queue, (left + self.caution * int(costmap.data[neighbour]) / 100.0, neighbour))
        return Found(np.empty((0, 2), np.int32), len(came))

    def _neighbours(self, costmap: Costmap, cell: Cell) -> Iterator[Cell]:
        row, column = cell
        for down, right in MOVES:
            # A diagonal cuts no corner: the cells on both its sides must be free as well.
            touched = (row + down, column), (row, column + right), (row + down, column + right)
            if all(self._free(costmap, each) for each in touched):
                yield touched[-1]

    def _free(self, costmap: Costmap, cell: Cell) -> bool:
        inside = 0 <= cell[0] < costmap.info.height and 0 <= cell[1] < costmap.info.width
        return inside and bool(self._open[costmap.data[cell]])


def _way(came: dict[Cell, Cell], cell: Cell) -> list[Cell]:
    way = [cell]
    while came[cell] != cell:
        cell = came[cell]
        way.append(cell)
    return way[::-1]
