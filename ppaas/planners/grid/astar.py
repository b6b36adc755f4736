"""A*: the same paths as Dijkstra's algorithm, with fewer cells looked at."""

from collections.abc import Callable
from typing import ClassVar

from ppaas.costmap.costmap import Costmap
from ppaas.planners.grid.astar_search import AimedSearch
from ppaas.planners.grid.padded_map import PaddedMap
from ppaas.planners.prepared import PreparedPlanner
from ppaas.planners.traits import Optimal, Traits
from ppaas.planners.watch import proceed


class AStar(PreparedPlanner):
    """Grows the field towards the start, by the octile distance that is left.

    Paths cost what those of ``dijkstra`` do, and no more cells are settled for them.
    """

    name: ClassVar[str] = "astar"
    purpose: ClassVar[str] = "Cheapest path in the open, where the straight way is nearly free; hardly any preparation."
    traits: ClassVar[Traits] = Traits(optimal=Optimal.ALWAYS, indexed=True)

    def prepare(self, costmap: Costmap, *, threads: int = 1, check: Callable[[], None] = proceed) -> AimedSearch:
        """Copy the map with a margin."""
        return AimedSearch(PaddedMap(costmap, allow_unknown=self.allow_unknown, check=check))
