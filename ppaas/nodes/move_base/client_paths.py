"""Paths of clients: goals of the action ``follow_path``, and paths that the service ``is_path_valid`` checks."""

import math
from collections.abc import Collection, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidInput, NotFound, NoValidPath, PPaaSError, TransformError
from ppaas.geometry import Pose2D, Poses, quaternion_of
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import PoseStamped
from ppaas.messages.nav2_motions import FollowPathError, FollowPathGoal
from ppaas.messages.nav2_msgs import IsPathValidRequest, IsPathValidResponse
from ppaas.messages.nav_msgs import Path
from ppaas.navigation.move_base import Trigger
from ppaas.nodes.frames import MAP
from ppaas.nodes.message_checks import pose_in
from ppaas.transforms.planar import TransformTree

# -- paths of any kind -------------------------------------------------------------------------------------------------

MOST = 10_000
"""Largest number of poses of a path."""

SAME_PLACE = 0.1
"""Differences of distances below which the robot is at the first of several parts of its path [m]."""


def poses_of_path(path: Path, tree: TransformTree, what: str = "pose") -> list[Pose2D]:
    """Return the poses of a path in the map frame; those without a frame are in the frame of its header.

    Raises
    ------
    InvalidInput
        There are too many, or one is not finite or has no frame.
    TransformError
        A frame is unknown.
    """
    poses = listed(path)
    if len(poses) > MOST:
        raise InvalidInput(f"a path may have at most {MOST} poses, not {len(poses)}")
    return [
        pose_in(tree, MAP, _in_frame(pose, path.header), f"{what} {number}") for number, pose in enumerate(poses, 1)
    ]


def listed(path: Path) -> list[PoseStamped]:
    """Return the poses of a path as messages."""
    assert isinstance(path.poses, list), "messages of clients are decoded"
    return path.poses


def _in_frame(pose: PoseStamped, header: Header) -> PoseStamped:
    return pose if pose.header.frame_id else PoseStamped(header, pose.pose)


def nearest_index(points: NDArray[np.float64], pose: Pose2D) -> tuple[int, float]:
    """Return the index of the point (n, 2) at which a robot is on a path, and its distance from it [m].

    Where the path passes the robot more than once, it is the first time.
    """
    apart = np.hypot(*(points - pose[:2]).T)
    least = float(apart.min())
    return int(np.argmax(apart <= least + SAME_PLACE)), least


# -- the action ``follow_path`` ----------------------------------------------------------------------------------------

APART, LONGEST = 0.1, 1000.0
"""Distance between poses that are kept and followed [m], and greatest length of a path [m]."""

FAR = 1.0
"""Distance from its path within which a robot begins to follow it [m]."""

DEFAULT_CONTROLLER_IDS = ("", "FollowPath")
"""Values of ``controller_id`` that mean the robot's own local planner; the second is Nav2's name of its only one."""

CODES = {
    Trigger.PLANNING: FollowPathError.NO_VALID_CONTROL,
    Trigger.CONTROLLING: FollowPathError.PATIENCE_EXCEEDED,
    Trigger.OSCILLATION: FollowPathError.FAILED_TO_MAKE_PROGRESS,
    Trigger.NO_PROGRESS: FollowPathError.FAILED_TO_MAKE_PROGRESS,
}
"""``error_code`` by what was tried in vain."""


def error_of(error: PPaaSError) -> FollowPathError:
    """Return the ``error_code`` of a goal that is refused."""
    if isinstance(error, TransformError):
        return FollowPathError.TF_ERROR
    return FollowPathError.INVALID_CONTROLLER if isinstance(error, NotFound) else FollowPathError.INVALID_PATH


def check_controller(name: str, own: Collection[str]) -> None:
    """Check the ``controller_id`` of a goal; raises ``NotFound`` if it is not the robot's local planner."""
    if name not in DEFAULT_CONTROLLER_IDS and name not in own:
        raise NotFound("controller", name, [*DEFAULT_CONTROLLER_IDS[1:], *own])


def path_to_follow(goal: FollowPathGoal, tree: TransformTree) -> tuple[Pose2D, ...]:
    """Return the path of a goal in the map frame, without poses that are nearer than `APART` to the one before.

    Raises
    ------
    InvalidInput
        It is empty or too long, or has too many poses, or one is not finite or has no frame.
    TransformError
        A frame is unknown.
    """
    poses = poses_of_path(goal.path, tree)
    if not poses:
        raise InvalidInput("the path is empty: there is nothing to follow")
    kept = poses[:1]
    length = 0.0
    for before, pose in pairwise(poses):
        length += before.distance_to(pose)
        if kept[-1].distance_to(pose) >= APART:
            kept.append(pose)
    if length > LONGEST:
        raise InvalidInput(f"a path may be at most {LONGEST:g} m long, not {length:.0f} m")
    if kept[-1] != poses[-1]:
        kept.append(poses[-1])
    return tuple(kept)


def rows_of(path: Sequence[Pose2D]) -> Poses:
    """Return a path as (n, 7) rows at most `APART` from each other; those between two poses head as the first."""
    rows = []
    for one, other in pairwise(path):
        steps = max(math.ceil(one.distance_to(other) / APART), 1)
        heading = quaternion_of(one.theta)
        for step in range(steps):
            part = step / steps
            rows.append((one.x + part * (other.x - one.x), one.y + part * (other.y - one.y), 0.0, *heading))
    rows.append((path[-1].x, path[-1].y, 0.0, *quaternion_of(path[-1].theta)))
    return np.array(rows)


def rest_for(rows: Poses, start: Pose2D) -> Poses:
    """Return the part of a path from where the robot is on it to its end.

    Raises
    ------
    NoValidPath
        The robot is not on it.
    """
    index, apart = nearest_index(rows[:, :2], start)
    if apart > FAR:
        raise NoValidPath(f"the robot is {apart:.2f} m away from the path: begin it where the robot is")
    return rows[index:]


# -- the service ``is_path_valid`` -------------------------------------------------------------------------------------


def check_path(request: IsPathValidRequest, costmap: Costmap, tree: TransformTree, pose: Pose2D | None) -> Message:
    """Return which poses of a path are not free.

    As in Nav2, the poses behind the robot are not checked. Cells in which the centre of the robot would touch an
    obstacle are not free, nor are those of at least ``max_cost``, and places outside the map.

    Parameters
    ----------
    request : IsPathValidRequest
    costmap : Costmap
        The map with observed obstacles.
    tree : TransformTree
    pose : Pose2D, optional
        Pose of the robot in the map frame; the whole path is checked without it.

    Raises
    ------
    InvalidInput
        There are too many poses, one is not finite or has no frame, or a layer or a footprint is named.
    TransformError
        A frame is unknown.
    """
    if request.layer_name or request.footprint:
        raise InvalidInput(
            "paths are checked for the robot's footprint on the whole costmap: leave layer_name and footprint empty"
        )
    poses = poses_of_path(request.path, tree)
    if not poses:
        return IsPathValidResponse(is_valid=False, invalid_pose_indices=[])
    points = np.array([each[:2] for each in poses])
    first = 0 if pose is None else nearest_index(points, pose)[0]
    last = _last_index(points, first, request.max_lookahead_distance)
    costs = costmap.costs_at(points[first:last], outside=LETHAL_OBSTACLE)
    unknown = costs == NO_INFORMATION
    blocked = np.where(
        unknown, request.consider_unknown_as_obstacle, costs >= min(request.max_cost, INSCRIBED_INFLATED_OBSTACLE)
    )
    found = (np.nonzero(blocked)[0] + first).tolist()
    return IsPathValidResponse(not found, found[:1] if request.stop_at_first_collision else found)


def _last_index(points: NDArray[np.float64], first: int, ahead: float) -> int:
    """Return the number of points up to a distance along the path ahead of one [m]; all if it is negative."""
    if not ahead >= 0.0:  # nor NaN
        return len(points)
    along = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points[first:], axis=0).T))))
    return first + int(np.searchsorted(along, ahead, side="right"))
