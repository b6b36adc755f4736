"""Goals of the action ``navigate_through_poses``, updates of goals, and goals that give way to clients' goals."""

import math

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import PoseStamped
from ppaas.messages.nav2_msgs import NavigateThroughPosesGoal
from ppaas.messages.people_coordination import GoalUpdate
from ppaas.navigation.action_goals import GoalState
from ppaas.navigation.events import Goal
from ppaas.nodes.base import Payload
from ppaas.nodes.frames import MAP
from ppaas.nodes.message_checks import pose_in
from ppaas.nodes.topics import GOAL_UPDATE
from ppaas.people.names import FOLLOWING_GOAL
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


GAVE_WAY = "The robot has a goal of a client, or runs a behaviour, which goals to follow a person do not replace."


def gives_way(goal: Goal, active: GoalState[Goal] | None, *, behaves: bool) -> bool:
    """Return whether a goal is one to follow a person, while a client has a goal or a behaviour.

    Both may have been sent at the same time, so that the node which follows did not know of the client.
    """
    has_client = behaves or (active is not None and not active.goal.id.startswith(FOLLOWING_GOAL))
    return has_client and goal.id.startswith(FOLLOWING_GOAL)


def update_of(topic: str, message: Payload) -> GoalUpdate | None:
    """Return the update of a goal that a message is, None if it is something else; one of Nav2 has no id."""
    if isinstance(message, PoseStamped) and topic == GOAL_UPDATE.name:
        return GoalUpdate("", message)
    return message if isinstance(message, GoalUpdate) else None


def is_update_of(update: GoalUpdate, goal: Goal) -> bool:
    """Return whether an update moves a goal: by its id or, without one, because it is not older, as in Nav2."""
    if update.goal_id:
        return update.goal_id == goal.id
    stamp = update.target_pose.header.stamp.seconds()
    return stamp == 0.0 or stamp >= goal.stamp


def limit_of_goal(update: GoalUpdate, goal: Goal) -> float:
    """Return the speed limit of a goal after an update [m/s]; an update without an id leaves it unchanged.

    Raises
    ------
    InvalidInput
        It is not finite, or negative.
    """
    if not (math.isfinite(update.speed_limit) and update.speed_limit >= 0.0):
        raise InvalidInput(f"speed_limit of a goal must be 0 for none, or a speed [m/s], not {update.speed_limit}")
    return update.speed_limit if update.goal_id else goal.speed_limit
