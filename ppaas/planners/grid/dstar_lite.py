"""D* Lite: replans after changes of the map and moves of the robot, expanding only the affected cells."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np

from ppaas.costmap.costmap import Costmap
from ppaas.planners.ends import Ends
from ppaas.planners.grid.dstar_lite_field import DStarLiteField
from ppaas.planners.grid_planner import Found, GridPlanner
from ppaas.planners.traits import Optimal, Traits

MAX_CHANGED = 1 / 16
"""Fraction of changed cells beyond which growing a new field is faster than updating the old one."""


class DStarLite(GridPlanner):
    """Keeps its cost field from plan to plan, as long as the goal and the size of the map are the same.

    It compares the map with the last one to find changed cells. Paths cost the same as with ``dijkstra``. The field
    of a plan that was cancelled or timed out is kept as well.
    """

    name: ClassVar[str] = "dstar_lite"
    purpose: ClassVar[str] = "Cheapest path again and again to one goal, while the map changes near the robot."
    traits: ClassVar[Traits] = Traits(optimal=Optimal.ALWAYS, incremental=True)

    def __init__(self, *, allow_unknown: bool = True, smooth: bool = False) -> None:
        super().__init__(allow_unknown=allow_unknown, smooth=smooth)
        self._field: DStarLiteField | None = None

    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Return the cells of a cheapest path; ``expanded`` counts the expansions of this plan only."""
        field = self._updated(costmap, ends, check)
        if field is None:
            field = self._field = DStarLiteField(costmap, ends.goal, allow_unknown=self.allow_unknown, check=check)
        before = field.settled
        reached = field.reach(ends.start, check)
        cells = field.path(check) if reached else np.empty((0, 2), np.int32)
        return Found(cells, field.settled - before)

    def _updated(self, costmap: Costmap, ends: Ends, check: Callable[[], None]) -> DStarLiteField | None:
        """Return the last field, updated to the current costs; None if a new one must be grown."""
        field = self._field
        if field is None or field.goal != ends.goal or field.shape != costmap.info.shape or field.worn:
            return None
        changed = field.differing(costmap, check)
        if len(changed) > MAX_CHANGED * costmap.data.size:
            return None
        field.amend(costmap, changed, check)
        return field
