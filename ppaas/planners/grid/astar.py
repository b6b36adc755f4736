"""A*: paths of the same cost as Dijkstra's algorithm, with fewer expanded cells."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.planners.grid.kernels.astar import COUNT, EXTRA_STATE, aim, walk
from ppaas.planners.grid.padded_map import PaddedMap
from ppaas.planners.grid.search_memory import BucketRing, ReusableValues
from ppaas.planners.kernels.moves import PAUSED, POOL_EMPTY, SETTLED
from ppaas.planners.prepared import Prepared, PreparedPlanner
from ppaas.planners.traits import Optimal, Traits
from ppaas.planners.units import CARDINAL, DIAGONAL
from ppaas.planners.watch import proceed

# -- search on a map that is prepared once -----------------------------------------------------------------------------

SLICE_CELLS = 20_000
"""Cells settled between two checks: about 2 ms."""

SLICE_WALKED = 50_000
"""Cells of a path written between two checks."""


class AStarSearch(Prepared):
    """Cost field that grows from the goal only until the value of the start is final.

    Parameters
    ----------
    padded : PaddedMap
        Only read.
    """

    def __init__(self, padded: PaddedMap) -> None:
        self._map = padded
        self._least = np.array([padded.least, padded.least // CARDINAL * DIAGONAL])
        self._field = ReusableValues((padded.costs.size,), 2 * padded.path_bound + 2)
        self._ring = BucketRing(padded.most + int(self._least[1]), padded.grain, 8, EXTRA_STATE)

    @property
    def nbytes(self) -> int:
        """Memory used in addition to the costmap, if all cells have been touched [bytes]."""
        return self._map.nbytes + self._field.values.nbytes + self._ring.nbytes

    def twin(self) -> "AStarSearch":
        """Return a search for another thread; the map is shared."""
        return AStarSearch(self._map)

    def path(
        self, start_row: int, start_column: int, goal_row: int, goal_column: int, check: Callable[[], None] = proceed
    ) -> NDArray[np.int32]:
        """Return the (n, 2) cells of a cheapest path; empty if there is no path."""
        start, goal = (start_row, start_column), (goal_row, goal_column)
        base = self._field.begin()
        reached = self._grow(base, self._map.flat(goal), self._map.flat(start), check)
        self.expanded = int(self._ring.state[COUNT])
        return self._walk(base, start, check) if reached else np.empty((0, 2), np.int32)

    def _grow(self, base: int, goal: int, target: int, check: Callable[[], None]) -> bool:
        ring, costs, stride, weights = self._ring, self._map.costs, self._map.shape[1], self._map.weights
        ring.state[COUNT] = -1
        while True:
            check()
            outcome = aim(
                self._field.values, costs, stride, weights, self._least,
                ring.heads, ring.marks, ring.pool, ring.state, base, base + self._field.span, goal, target, SLICE_CELLS,
            )  # fmt: skip
            if outcome == POOL_EMPTY:
                ring.grow(check)
            elif outcome != PAUSED:
                return bool(outcome == SETTLED)

    def _walk(self, base: int, start: tuple[int, int], check: Callable[[], None]) -> NDArray[np.int32]:
        value = (int(self._field.values[self._map.flat(start)]) - base) >> 1
        most = value // self._map.least + 1
        cells = np.empty((most, 2), np.int32)
        cells[0] = start
        count, before = 1, 0
        while count > before:
            check()
            before = count
            count = walk(
                self._field.values, self._map.costs, self._map.shape[1], self._map.weights, base,
                cells, count, min(SLICE_WALKED, most - count),
            )  # fmt: skip
        return cells[:count].copy()


# -- the planner -------------------------------------------------------------------------------------------------------


class AStar(PreparedPlanner):
    """Grows the cost field from the goal towards the start, guided by the octile distance.

    Paths cost the same as with ``dijkstra``, and no more cells are settled.
    """

    name: ClassVar[str] = "astar"
    purpose: ClassVar[str] = "Cheapest path in the open, where the straight line is nearly free; little preparation."
    traits: ClassVar[Traits] = Traits(optimal=Optimal.ALWAYS, indexed=True)

    def prepare(self, costmap: Costmap, *, threads: int = 1, check: Callable[[], None] = proceed) -> AStarSearch:
        """Return a search on a padded copy of the map."""
        return AStarSearch(PaddedMap(costmap, allow_unknown=self.allow_unknown, check=check))
