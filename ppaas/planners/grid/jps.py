"""Jump point search: paths of the same cost as A*, with few expanded cells."""

from collections.abc import Callable
from typing import ClassVar

from ppaas.costmap.costmap import Costmap
from ppaas.planners.ends import Ends
from ppaas.planners.grid.dijkstra import Dijkstra
from ppaas.planners.grid.jump_map import JumpMap
from ppaas.planners.grid.jump_search import LARGE, JumpSearch
from ppaas.planners.grid_planner import Found
from ppaas.planners.prepared import PreparedPlanner
from ppaas.planners.traits import Optimal, Traits
from ppaas.planners.watch import proceed


class JumpPointSearch(PreparedPlanner):
    """Jumps over cells where a cheapest path need not turn.

    It is fast on large areas of one cost. Where costs change from cell to cell, it expands single cells; its paths are
    the cheapest there too. Above 256 x 256 cells, a cost field, as of ``dijkstra``, takes over such searches, and all
    those on a writable map, which takes longer to prepare than to search.
    """

    name: ClassVar[str] = "jps"
    purpose: ClassVar[str] = "Cheapest path where large areas have one cost; prepares a map in milliseconds."
    traits: ClassVar[Traits] = Traits(optimal=Optimal.ALWAYS, indexed=True)

    def prepare(self, costmap: Costmap, *, threads: int = 1, check: Callable[[], None] = proceed) -> JumpSearch:
        """Precompute the ends of straight jumps."""
        return JumpSearch(JumpMap(costmap, allow_unknown=self.allow_unknown, check=check))

    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Return the cells between two ends."""
        if costmap.data.flags.writeable and costmap.data.size > LARGE:
            return Dijkstra(allow_unknown=self.allow_unknown).search(costmap, ends, threads=threads, check=check)
        return super().search(costmap, ends, threads=threads, check=check)
