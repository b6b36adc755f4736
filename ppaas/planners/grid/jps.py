"""Jump point search: paths of the same cost as A*, with few expanded cells."""

from collections.abc import Callable
from typing import ClassVar

from ppaas.costmap.costmap import Costmap
from ppaas.planners.grid.jump_map import JumpMap
from ppaas.planners.grid.jump_search import JumpSearch
from ppaas.planners.prepared import PreparedPlanner
from ppaas.planners.traits import Optimal, Traits
from ppaas.planners.watch import proceed


class JumpPointSearch(PreparedPlanner):
    """Jumps over cells where a cheapest path need not turn.

    It is fast on large areas of one cost. Where costs change from cell to cell, it expands single cells; its paths are
    the cheapest there too.
    """

    name: ClassVar[str] = "jps"
    purpose: ClassVar[str] = "Cheapest path where large areas have one cost; prepares a map in milliseconds."
    traits: ClassVar[Traits] = Traits(optimal=Optimal.ALWAYS, indexed=True)

    def prepare(self, costmap: Costmap, *, threads: int = 1, check: Callable[[], None] = proceed) -> JumpSearch:
        """Precompute the ends of straight jumps."""
        return JumpSearch(JumpMap(costmap, allow_unknown=self.allow_unknown, check=check))
