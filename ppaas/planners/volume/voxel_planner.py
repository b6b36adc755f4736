"""Base of the planners in space: they grow a cost field from the goal and descend it from the start."""

from abc import abstractmethod
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.voxels import VoxelCostmap
from ppaas.errors import InvalidPlanner, NoValidPath
from ppaas.geometry import Poses
from ppaas.planners.base import PlanResult
from ppaas.planners.base3d import PlanRequest3D, Pose3D, VolumePlanner
from ppaas.planners.volume.ends import VoxelEnds, place_ends
from ppaas.planners.volume.field import VoxelField
from ppaas.planners.watch import Watch
from ppaas.planners.weights import exact_weights


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
        poses = _path_poses(costmap, cells, ends.start_pose, ends.goal_pose)
        return PlanResult(
            cells=cells,
            poses=poses,
            cost=_path_cost(costmap, cells),
            length=_path_length(poses),
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


def _path_cost(costmap: VoxelCostmap, cells: NDArray[np.int32]) -> float:
    """Return the cost of a path, computed in float64.

    As in the plane, a move weighs as much as the voxel nearer to the start. All voxels count except the goal.

    Parameters
    ----------
    costmap : VoxelCostmap
    cells : (n, 3) array
        Layer, row, column from start to goal.
    """
    layers, rows, columns = cells[:-1].T
    weights = exact_weights()[costmap.data[layers, rows, columns]]
    return float(np.sum(weights * np.sqrt(np.abs(np.diff(cells, axis=0)).sum(axis=1))))


def _path_poses(costmap: VoxelCostmap, cells: NDArray[np.int32], start: Pose3D, goal: Pose3D) -> Poses:
    """Return the (n, 7) poses of a path: the places of its voxels, with ``start`` and ``goal`` at its ends.

    Each pose heads for the next one; a vertical move keeps the heading. If both ends are in one voxel, the only pose is
    the goal.
    """
    points = costmap.places(cells)
    points[0] = start[:3]
    points[-1] = goal[:3]
    yaws = np.full(len(cells), start.theta)
    steps = np.diff(points, axis=0)
    moved = np.flatnonzero(np.hypot(steps[:, 0], steps[:, 1]) > 0.0)
    moved = moved[moved > 0]
    if len(moved):
        last = np.searchsorted(moved, np.arange(len(cells)), side="right") - 1
        headings = np.arctan2(steps[moved, 1], steps[moved, 0])
        yaws = np.where(last < 0, start.theta, headings[last])
    yaws[-1] = goal.theta
    poses = np.zeros((len(cells), 7))
    poses[:, :3] = points
    poses[:, 5], poses[:, 6] = np.sin(yaws / 2.0), np.cos(yaws / 2.0)
    return poses


def _path_length(poses: Poses) -> float:
    """Return the length along the poses [m]."""
    return float(np.sum(np.linalg.norm(np.diff(poses[:, :3], axis=0), axis=1)))
