"""Jump point search: the same paths as A*, with few cells looked at one by one."""

from collections.abc import Callable
from typing import ClassVar

from ppaas.costmap.costmap import Costmap
from ppaas.planners.grid.jump_map import JumpMap
from ppaas.planners.grid.jump_search import JumpSearch
from ppaas.planners.prepared import PreparedPlanner
from ppaas.planners.traits import Optimal, Traits
from ppaas.planners.watch import proceed


class JumpPointSearch(PreparedPlanner):
    """Jumps over the cells where a cheapest path need not turn.

    It is made for wide areas of one cost. Where costs change from cell to cell it goes from cell to cell as well; its
    paths are cheapest there too.
    """

    name: ClassVar[str] = "jps"
    purpose: ClassVar[str] = "Cheapest path where large areas have one cost; prepares a map in milliseconds."
    traits: ClassVar[Traits] = Traits(optimal=Optimal.ALWAYS, indexed=True)

    def prepare(self, costmap: Costmap, *, threads: int = 1, check: Callable[[], None] = proceed) -> JumpSearch:
        """Work out where jumps end."""
        return JumpSearch(JumpMap(costmap, allow_unknown=self.allow_unknown, check=check))
