"""Planners in space, A* and Dijkstra: they grow a cost field from the goal and descend it from the start."""

import math
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.voxels import VoxelCostmap
from ppaas.errors import (
    GoalOccupied,
    GoalOutsideMap,
    InvalidPlanner,
    NoValidPath,
    PlanningError,
    StartOccupied,
    StartOutsideMap,
)
from ppaas.geometry import Poses
from ppaas.maps.voxels import Voxel
from ppaas.planners.base import PlanResult
from ppaas.planners.base3d import PlanRequest3D, Pose3D, VolumePlanner
from ppaas.planners.volume.field import VoxelField
from ppaas.planners.watch import Watch
from ppaas.planners.weights import exact_weights, passable

# -- ends of a plan: from poses to free voxels -------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class VoxelEnds:
    """The start and goal voxels of a plan.

    Parameters
    ----------
    start, goal : (layer, row, column)
        Free voxels.
    start_pose, goal_pose : Pose3D
        The requested pose, or the place of the free voxel that replaces it, with the requested heading.
    """

    start: Voxel
    goal: Voxel
    start_pose: Pose3D
    goal_pose: Pose3D


def place_ends(costmap: VoxelCostmap, request: PlanRequest3D, *, allow_unknown: bool) -> VoxelEnds:
    """Return the voxels in which a plan begins and ends.

    Raises
    ------
    StartOutsideMap, GoalOutsideMap, StartOccupied, GoalOccupied
    """
    open_costs = passable(allow_unknown)
    start, start_pose = _place(costmap, "start", request.start, request.tolerance, open_costs)
    goal, goal_pose = _place(costmap, "goal", request.goal, request.tolerance, open_costs)
    return VoxelEnds(start, goal, start_pose, goal_pose)


_OUTSIDE: dict[str, type[PlanningError]] = {"start": StartOutsideMap, "goal": GoalOutsideMap}
_OCCUPIED: dict[str, type[PlanningError]] = {"start": StartOccupied, "goal": GoalOccupied}


def _place(
    costmap: VoxelCostmap, what: str, pose: Pose3D, tolerance: float, open_costs: NDArray[np.bool_]
) -> tuple[Voxel, Pose3D]:
    info = costmap.info
    # Clip first: the voxel index of a finite but very distant pose would overflow.
    near = np.clip(pose[:3], np.subtract(info.origin, info.resolution), _end(costmap) + info.resolution)
    layer, row, column = costmap.nearest(near).tolist()
    if not (0 <= layer < info.depth and 0 <= row < info.height and 0 <= column < info.width):
        raise _OUTSIDE[what](
            f"the {what} {_format_xyz(pose)} is outside the map; the map covers {_format_xyz(Pose3D(*info.origin))} to "
            f"{_format_xyz(Pose3D(*_end(costmap).tolist()))}: give a pose inside, in the frame of the map"
        )
    if open_costs[costmap.data[layer, row, column]]:
        return (layer, row, column), pose
    free = _free_near(costmap, pose, (layer, row, column), tolerance, open_costs)
    if free is None:
        raise _OCCUPIED[what](
            f"the {what} {_format_xyz(pose)} is blocked: the robot would touch an obstacle, or has no floor below it. "
            f"No free place is within the tolerance of {tolerance} m; choose another {what} or a larger tolerance"
        )
    x, y, z = costmap.places(free).tolist()
    return free, Pose3D(x, y, z, pose.theta)


def _free_near(
    costmap: VoxelCostmap, pose: Pose3D, voxel: Voxel, tolerance: float, open_costs: NDArray[np.bool_]
) -> Voxel | None:
    """Return the free voxel whose place is nearest to a pose, within the tolerance; None if there is none."""
    info = costmap.info
    margin = math.ceil(min(tolerance / info.resolution, sum(info.shape))) + 1
    low = np.maximum(0, np.subtract(voxel, margin))
    high = np.minimum(info.shape, np.add(voxel, margin + 1))
    axes = [np.arange(first, last) for first, last in zip(low, high, strict=True)]
    places = [
        (axis + middle) * info.resolution + origin - wanted
        for axis, middle, origin, wanted in zip(axes, (0.0, 0.5, 0.5), info.origin[::-1], pose[2::-1], strict=True)
    ]
    squares = places[0][:, None, None] ** 2 + places[1][:, None] ** 2 + places[2] ** 2
    squares[~open_costs[costmap.data[np.ix_(*axes)]]] = np.inf
    best = np.unravel_index(np.argmin(squares), squares.shape)
    if squares[best] > tolerance**2:
        return None
    layer, row, column = np.add(best, low).tolist()
    return layer, row, column


def _end(costmap: VoxelCostmap) -> NDArray[np.float64]:
    info = costmap.info
    return np.add(info.origin, np.multiply(info.shape[::-1], info.resolution))


def _format_xyz(pose: Pose3D) -> str:
    return f"x={pose.x:.3f} y={pose.y:.3f} z={pose.z:.3f}"


# -- base of the planners ----------------------------------------------------------------------------------------------


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


# -- A*, with fewer expanded voxels ------------------------------------------------------------------------------------


class AStar3D(VoxelPlanner):
    """Grows the field from the goal towards the start, guided by the least cost of the remaining distance."""

    name: ClassVar[str] = "astar3d"
    purpose: ClassVar[str] = "Cheapest path in space where the straight line is nearly free: the first to try."

    def field(self, costmap: VoxelCostmap, ends: VoxelEnds, *, check: Callable[[], None]) -> VoxelField:
        """Return a field that grows towards the start."""
        goal = np.array([ends.goal])
        return VoxelField(costmap, goal, target=ends.start, allow_unknown=self.allow_unknown, check=check)


# -- Dijkstra's algorithm ----------------------------------------------------------------------------------------------


class Dijkstra3D(VoxelPlanner):
    """Grows the field in all directions alike until it reaches the start."""

    name: ClassVar[str] = "dijkstra3d"
    purpose: ClassVar[str] = "Cheapest path in space, without preparation; the baseline for the other."

    def field(self, costmap: VoxelCostmap, ends: VoxelEnds, *, check: Callable[[], None]) -> VoxelField:
        """Return a field that grows outward."""
        return VoxelField(costmap, np.array([ends.goal]), allow_unknown=self.allow_unknown, check=check)
