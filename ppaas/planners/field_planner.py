"""What all planners have in common that grow a field of costs from the goal and walk down it."""

from abc import abstractmethod
from collections.abc import Callable

import numpy as np

from ppaas.costmap.costmap import Costmap
from ppaas.errors import NoValidPath
from ppaas.planners.base import Planner, PlanRequest, PlanResult
from ppaas.planners.ends import Ends, place_ends
from ppaas.planners.grid_field import GridField
from ppaas.planners.path import path_cost, path_length, path_poses
from ppaas.planners.watch import Watch


class FieldPlanner(Planner):
    """Plans cheapest paths, in three stages: set up the arrays, grow the field from the goal, walk down it.

    Parameters
    ----------
    allow_unknown : bool
        Whether paths may lead through unknown cells, which then weigh 253.
    """

    def __init__(self, *, allow_unknown: bool = True) -> None:
        self.allow_unknown = allow_unknown

    @abstractmethod
    def grow(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> tuple[GridField, bool]:
        """Return a field, and whether it reaches the start, whose value is then final."""

    def plan(self, costmap: Costmap, request: PlanRequest) -> PlanResult:
        """Find a cheapest path.

        Raises
        ------
        InvalidInput
            A pose that is not finite, a negative tolerance or timeout.
        StartOutsideMap, GoalOutsideMap, StartOccupied, GoalOccupied, NoValidPath, PlanTimeout, PlanCancelled
        """
        watch = Watch(request)
        watch.check()
        ends = place_ends(costmap, request, allow_unknown=self.allow_unknown, check=watch.check)
        field, reached = self.grow(costmap, ends, threads=request.threads, check=watch.check)
        if not reached:
            raise NoValidPath(_unconnected(request, ends))
        cells = np.concatenate((ends.escape, field.path_from(ends.start)))
        poses = path_poses(costmap, cells, request.start, ends.goal_pose)
        return PlanResult(
            cells=cells,
            poses=poses,
            cost=path_cost(costmap, cells),
            length=path_length(poses),
            expanded=field.settled,
            seconds=watch.seconds(),
            planner=self.name,
        )


def _unconnected(request: PlanRequest, ends: Ends) -> str:
    return (
        f"no free way from x={request.start.x:.3f} y={request.start.y:.3f} to x={ends.goal_pose.x:.3f} "
        f"y={ends.goal_pose.y:.3f}; clear the costmap, or choose a goal on the robot's side of the obstacles"
    )
