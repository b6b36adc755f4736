"""Goals of the action ``navigate_through_poses``."""

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.nav2_msgs import NavigateThroughPosesGoal
from ppaas.nodes.frames import MAP
from ppaas.nodes.message_checks import pose_in
from ppaas.transforms.planar import TransformTree

MAX_POSES = 100
"""Largest number of poses of a goal; the path through all of them is planned once a second."""


def poses_of(goal: NavigateThroughPosesGoal, tree: TransformTree) -> list[Pose2D]:
    """Return the poses of a goal in the map frame.

    Raises
    ------
    InvalidInput
        There is none, there are too many, one is not finite or has no frame, or the goal names a behavior tree.
    TransformError
        The frame of a pose is unknown.
    """
    if goal.behavior_tree:
        raise InvalidInput("behavior trees are not supported: leave behavior_tree empty")
    if not 0 < len(goal.poses) <= MAX_POSES:
        raise InvalidInput(
            f"poses must have from 1 to {MAX_POSES} poses, not {len(goal.poses)}: "
            "follow_waypoints takes longer lists, and stops at each of their poses"
        )
    return [pose_in(tree, MAP, pose, f"pose {number}") for number, pose in enumerate(goal.poses, 1)]
