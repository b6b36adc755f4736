"""Ends of a plan in space: from the requested poses to the free voxels that a planner connects."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.voxels import VoxelCostmap
from ppaas.errors import GoalOccupied, GoalOutsideMap, PlanningError, StartOccupied, StartOutsideMap
from ppaas.maps.voxels import Voxel
from ppaas.planners.base3d import PlanRequest3D, Pose3D
from ppaas.planners.weights import passable


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
