"""Where a plan in space begins and ends: from the poses asked for to voxels that a planner can join."""

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
class Ends:
    """The two voxels to join, and the poses that belong to them.

    Parameters
    ----------
    start, goal : (layer, row, column)
        Free voxels.
    start_pose, goal_pose : Pose3D
        As asked for, or the free place that stands for it, with the heading asked for.
    """

    start: Voxel
    goal: Voxel
    start_pose: Pose3D
    goal_pose: Pose3D


def place_ends(costmap: VoxelCostmap, request: PlanRequest3D, *, allow_unknown: bool) -> Ends:
    """Find the voxels in which a plan begins and ends.

    Raises
    ------
    StartOutsideMap, GoalOutsideMap, StartOccupied, GoalOccupied
    """
    open_costs = passable(allow_unknown)
    start, start_pose = _place(costmap, "start", request.start, request.tolerance, open_costs)
    goal, goal_pose = _place(costmap, "goal", request.goal, request.tolerance, open_costs)
    return Ends(start, goal, start_pose, goal_pose)


_OUTSIDE: dict[str, type[PlanningError]] = {"start": StartOutsideMap, "goal": GoalOutsideMap}
_OCCUPIED: dict[str, type[PlanningError]] = {"start": StartOccupied, "goal": GoalOccupied}


def _place(
    costmap: VoxelCostmap, what: str, pose: Pose3D, tolerance: float, open_costs: NDArray[np.bool_]
) -> tuple[Voxel, Pose3D]:
    info = costmap.info
    # A pose may be finite and yet too far away to be counted in voxels.
    near = np.clip(pose[:3], np.subtract(info.origin, info.resolution), _end(costmap) + info.resolution)
    layer, row, column = costmap.nearest(near).tolist()
    if not (0 <= layer < info.depth and 0 <= row < info.height and 0 <= column < info.width):
        raise _OUTSIDE[what](
            f"the {what} {_spot(pose)} lies outside the map; it spans from {_spot(Pose3D(*info.origin))} to "
            f"{_spot(Pose3D(*_end(costmap).tolist()))}: give a pose inside, in the frame of the map"
        )
    if open_costs[costmap.data[layer, row, column]]:
        return (layer, row, column), pose
    free = _free_near(costmap, pose, (layer, row, column), tolerance, open_costs)
    if free is None:
        raise _OCCUPIED[what](
            f"at the {what} {_spot(pose)} the robot would hit something, or has nothing to stand on, and no free place "
            f"is within the tolerance of {tolerance} m; choose another {what} or a larger tolerance"
        )
    x, y, z = costmap.places(free).tolist()
    return free, Pose3D(x, y, z, pose.theta)


def _free_near(
    costmap: VoxelCostmap, pose: Pose3D, voxel: Voxel, tolerance: float, open_costs: NDArray[np.bool_]
) -> Voxel | None:
    """Return the free voxel whose place is nearest to a pose, no further than the tolerance."""
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


def _spot(pose: Pose3D) -> str:
    return f"x={pose.x:.3f} y={pose.y:.3f} z={pose.z:.3f}"
