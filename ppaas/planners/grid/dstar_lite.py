"""D* Lite: plans again after changes of the map and moves of the robot, by what they concern alone."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np

from ppaas.costmap.costmap import Costmap
from ppaas.planners.ends import Ends
from ppaas.planners.grid.dstar_lite_field import LivingField
from ppaas.planners.grid_planner import Found, GridPlanner
from ppaas.planners.traits import Optimal, Traits

MOST_CHANGED = 1 / 16
"""If more of the map changed than this part of it, a new field is grown sooner than the old one amended."""


class DStarLite(GridPlanner):
    """Keeps its field of costs-to-go from plan to plan, as long as the goal and the size of the map stay.

    Which cells have other costs than last time it finds itself. Paths cost what those of ``dijkstra`` do. What was done
    for a plan that was cancelled or timed out is kept.
    """

    name: ClassVar[str] = "dstar_lite"
    purpose: ClassVar[str] = "Cheapest path again and again to one goal, while the map changes near the robot."
    traits: ClassVar[Traits] = Traits(optimal=Optimal.ALWAYS, incremental=True)

    def __init__(self, *, allow_unknown: bool = True, smooth: bool = False) -> None:
        super().__init__(allow_unknown=allow_unknown, smooth=smooth)
        self._field: LivingField | None = None

    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Find the cells of a cheapest path; ``expanded`` counts those worked off for this plan alone."""
        field = self._amended(costmap, ends, check)
        if field is None:
            field = self._field = LivingField(costmap, ends.goal, allow_unknown=self.allow_unknown, check=check)
        before = field.settled
        reached = field.reach(ends.start, check)
        cells = field.path(check) if reached else np.empty((0, 2), np.int32)
        return Found(cells, field.settled - before)

    def _amended(self, costmap: Costmap, ends: Ends, check: Callable[[], None]) -> LivingField | None:
        """Return the field of last time with the costs of now; none if a new one is to be grown."""
        field = self._field
        if field is None or field.goal != ends.goal or field.shape != costmap.info.shape or field.worn:
            return None
        changed = field.differing(costmap, check)
        if len(changed) > MOST_CHANGED * costmap.data.size:
            return None
        field.amend(costmap, changed, check)
        return field
