"""The planner that reads shortest paths off an index of the map."""

from collections.abc import Callable
from typing import ClassVar

from ppaas.costmap.costmap import Costmap
from ppaas.planners.hub_labels.assembly import build_index
from ppaas.planners.hub_labels.index import HubIndex
from ppaas.planners.prepared import PreparedPlanner
from ppaas.planners.traits import Optimal, Traits
from ppaas.planners.watch import proceed
from ppaas.planners.weights import passable


class HubLabels(PreparedPlanner):
    """Plans by hub labels over the corners of a map."""

    name: ClassVar[str] = "hub_labels"
    purpose: ClassVar[str] = (
        "Shortest path in microseconds, off an index that is made once per map and robot radius; cells are free or "
        "blocked, their graded costs are ignored."
    )

    traits: ClassVar[Traits] = Traits(optimal=Optimal.UNIFORM, weighted=False, indexed=True)

    def prepare(self, costmap: Costmap, *, threads: int = 1, check: Callable[[], None] = proceed) -> HubIndex:
        """Build the index of a map.

        Raises
        ------
        InvalidPlanner
            The map is too large or too cluttered for one.
        """
        free = passable(self.allow_unknown)[costmap.data]
        return HubIndex(build_index(free, threads=threads, check=check))
