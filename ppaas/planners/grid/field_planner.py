"""What all planners have in common that grow a field of costs from the goal and walk down it."""

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar

import numpy as np

from ppaas.costmap.costmap import Costmap
from ppaas.planners.ends import Ends
from ppaas.planners.field.base import GridField
from ppaas.planners.grid_planner import Found, GridPlanner
from ppaas.planners.traits import Optimal, Traits


class FieldPlanner(GridPlanner):
    """Plans cheapest paths, in three stages: set up the arrays, grow the field from the goal, walk down it."""

    traits: ClassVar[Traits] = Traits(optimal=Optimal.ALWAYS)

    @abstractmethod
    def grow(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> tuple[GridField, bool]:
        """Return a field, and whether it reaches the start, whose value is then final."""

    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Find the cells of a cheapest path."""
        field, reached = self.grow(costmap, ends, threads=threads, check=check)
        cells = field.path_from(ends.start) if reached else np.empty((0, 2), np.int32)
        return Found(cells, field.settled)
