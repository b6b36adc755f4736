"""A*: paths of the same cost as Dijkstra's algorithm, with fewer expanded cells."""

from collections.abc import Callable
from typing import ClassVar

from ppaas.costmap.costmap import Costmap
from ppaas.planners.grid.astar_search import AStarSearch
from ppaas.planners.grid.padded_map import PaddedMap
from ppaas.planners.prepared import PreparedPlanner
from ppaas.planners.traits import Optimal, Traits
from ppaas.planners.watch import proceed


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
