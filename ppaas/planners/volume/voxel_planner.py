"""Base of the planners in space: they grow a cost field from the goal and descend it from the start."""

from abc import abstractmethod
from collections.abc import Callable

from ppaas.costmap.voxels import VoxelCostmap
from ppaas.errors import InvalidPlanner, NoValidPath
from ppaas.planners.base import PlanResult
from ppaas.planners.base3d import PlanRequest3D, VolumePlanner
from ppaas.planners.volume.ends import VoxelEnds, place_ends
from ppaas.planners.volume.field import VoxelField
from ppaas.planners.volume.path import path_cost, path_length, path_poses
from ppaas.planners.watch import Watch


class VoxelPlanner(VolumePlanner):
    """Planner on the voxels of a costmap; subclasses choose the field.

    Parameters
    ----------
    allow_unknown : bool
        Whether the robot may overlap unknown space; such a voxel weighs 253.
    """

    def __init__(self, *, allow_unknown: bool = True) -> None:
        self.allow_unknown = allow_unknown

    @abstractmethod
    def field(self, costmap: VoxelCostmap, ends: VoxelEnds, *, check: Callable[[], None]) -> VoxelField:
        """Return the cost field that ``plan`` grows until it reaches ``ends.start``."""

    def plan(self, costmap: VoxelCostmap, request: PlanRequest3D) -> PlanResult:
        """Find a path.

        Raises
        ------
        InvalidPlanner
            The map or the request is one of planners in the plane.
        InvalidInput
            A pose is not finite, or the tolerance or the timeout is negative.
        StartOutsideMap, GoalOutsideMap, StartOccupied, GoalOccupied, NoValidPath, PlanTimeout, PlanCancelled
        """
        _check_kind(self.name, costmap, request)
        watch = Watch(request.from_above())
        watch.check()
        ends = place_ends(costmap, request, allow_unknown=self.allow_unknown)
        field = self.field(costmap, ends, check=watch.check)
        if not field.grow(ends.start):
            raise NoValidPath(
                f"no free path in space from {tuple(request.start)} to {tuple(request.goal)}; choose a goal that the "
                "robot can reach, a smaller robot or a higher step"
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
    """Raise if a program uses a planner in space like one in the plane: both kinds are created by name."""
    if not (isinstance(costmap, VoxelCostmap) and isinstance(request, PlanRequest3D)):
        raise InvalidPlanner(
            f"{name} plans in space: it takes a VoxelCostmap (see inflate_voxels) and a PlanRequest3D, not "
            f"{type(costmap).__name__} and {type(request).__name__}"
        )
