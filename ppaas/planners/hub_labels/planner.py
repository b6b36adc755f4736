"""The planner that reads shortest paths off an index of the map."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidInput
from ppaas.planners.hub_labels.assembly import build_index
from ppaas.planners.hub_labels.head import fingerprint, unseal
from ppaas.planners.hub_labels.index import HubIndex
from ppaas.planners.hub_labels.kernels.bits import Words
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
        """Open the index of a map that others have made, or build it.

        Raises
        ------
        InvalidPlanner
            The map is too large or too cluttered for one.
        """
        free = passable(self.allow_unknown)[costmap.data]
        content = costmap.indexes(self.name, check) if costmap.indexes is not None else None
        shared = unseal_if_of(free, content) if content is not None else None
        return HubIndex(build_index(free, threads=threads, check=check) if shared is None else shared)


def unseal_if_of(free: NDArray[np.bool_], content: memoryview) -> Words | None:
    """Return the index in a file, or None: what is unknown may be free there and blocked here, or it is none."""
    try:
        return unseal(content, fingerprint(free))
    except InvalidInput:
        return None
