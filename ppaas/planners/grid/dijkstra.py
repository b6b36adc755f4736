"""Dijkstra's algorithm on the costmap: cheapest paths without preparation."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np

from ppaas.costmap.costmap import Costmap
from ppaas.planners.ends import Ends
from ppaas.planners.field.base import GridField
from ppaas.planners.field.cost_field import CostField
from ppaas.planners.grid_planner import Found, GridPlanner
from ppaas.planners.traits import Optimal, Traits


class Dijkstra(GridPlanner):
    """Grows a cost field from the goal in all directions until the value of the start is final, and descends it."""

    name: ClassVar[str] = "dijkstra"
    purpose: ClassVar[str] = "Cheapest path on any grid, without preparation; the baseline for the others."
    traits: ClassVar[Traits] = Traits(optimal=Optimal.ALWAYS)

    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Return the cells of a cheapest path."""
        field, reached = self.grow(costmap, ends, threads=threads, check=check)
        cells = field.path_from(ends.start) if reached else np.empty((0, 2), np.int32)
        return Found(cells, field.settled)

    def grow(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> tuple[GridField, bool]:
        """Return a cost field, and whether it reaches the start; the value of the start is then final."""
        field = CostField(
            costmap, np.array([ends.goal]), allow_unknown=self.allow_unknown, threads=threads, check=check
        )
        return field, field.grow(ends.start)
