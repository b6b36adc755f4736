"""What all planners in space have in common that grow a field of costs from the goal and walk down it."""

from abc import abstractmethod
from collections.abc import Callable

from ppaas.costmap.voxels import VoxelCostmap
from ppaas.errors import InvalidPlanner, NoValidPath
from ppaas.planners.base import PlanResult
from ppaas.planners.base3d import PlanRequest3D, VolumePlanner
from ppaas.planners.volume.ends import Ends, place_ends
from ppaas.planners.volume.field import VoxelField
from ppaas.planners.volume.path import path_cost, path_length, path_poses
from ppaas.planners.watch import Watch


class VoxelPlanner(VolumePlanner):
    """Plans from voxel to voxel.

    Parameters
    ----------
    allow_unknown : bool
        Whether paths may lead where the robot would reach into the unknown; such a place weighs 253.
    """

    def __init__(self, *, allow_unknown: bool = True) -> None:
        self.allow_unknown = allow_unknown

    @abstractmethod
    def field(self, costmap: VoxelCostmap, ends: Ends, *, check: Callable[[], None]) -> VoxelField:
        """Return the field to grow until it reaches ``ends.start``."""

    def plan(self, costmap: VoxelCostmap, request: PlanRequest3D) -> PlanResult:
        """Find a path.

        Raises
        ------
        InvalidPlanner
            The map or the request is one of the plane.
        InvalidInput
            A pose that is not finite, a negative tolerance or timeout.
        StartOutsideMap, GoalOutsideMap, StartOccupied, GoalOccupied, NoValidPath, PlanTimeout, PlanCancelled
        """
        _check_kind(self.name, costmap, request)
        watch = Watch(request.from_above())
        watch.check()
        ends = place_ends(costmap, request, allow_unknown=self.allow_unknown)
        field = self.field(costmap, ends, check=watch.check)
        if not field.grow(ends.start):
            raise NoValidPath(
                f"no free way in space from {tuple(request.start)} to {tuple(request.goal)}; choose a goal on the "
                "robot's side of the obstacles, a smaller robot or a higher step"
            )
        cells = field.path_from(ends.start)
        poses = path_poses(costmap, cells, ends.start_pose, ends.goal_pose)
        return PlanResult(
            cells=cells,
            poses=poses,
            cost=path_cost(costmap, cells),
            length=path_length(poses),
            expanded=field.settled,
            seconds=watch.seconds(),
            planner=self.name,
        )


def _check_kind(name: str, costmap: object, request: object) -> None:
    """Planners in space and in the plane are made by name, so a program may mistake one for the other."""
    if not (isinstance(costmap, VoxelCostmap) and isinstance(request, PlanRequest3D)):
        raise InvalidPlanner(
            f"{name} plans in space: give it a VoxelCostmap, as inflate_voxels makes it, and a PlanRequest3D, not "
            f"{type(costmap).__name__} and {type(request).__name__}"
        )
