"""Actions of Nav2 and of this project that a clone serves by the topics of a ROS 1 action, with their topics."""

from typing import NamedTuple

from ppaas.messages import explore_msgs, nav2_motions, nav2_msgs, nav2_servers
from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray
from ppaas.messages.base.message import Message
from ppaas.nodes.base import Topic


class Nav2ActionTopics(NamedTuple):
    """Topics of an action."""

    goal: Topic
    cancel: Topic
    status: Topic
    feedback: Topic
    result: Topic


def _topics(
    name: str, goal: type[Message], feedback: type[Message], result: type[Message], *, once: bool = True
) -> Nav2ActionTopics:
    """Return the topics of an action; ``once`` is for results that no restored container may publish again."""
    return Nav2ActionTopics(
        Topic(f"{name}/goal", goal, many_publishers=True),
        Topic(f"{name}/cancel", GoalID, many_publishers=True),
        Topic(f"{name}/status", GoalStatusArray, stream=True),
        Topic(f"{name}/feedback", feedback, stream=True),
        Topic(f"{name}/result", result, published_once=once, lasting=once, depth=1000 if once else 64),
    )


NAVIGATE_THROUGH_POSES = _topics(
    "navigate_through_poses",
    nav2_msgs.NavigateThroughPosesActionGoal,
    nav2_msgs.NavigateThroughPosesActionFeedback,
    nav2_msgs.NavigateThroughPosesActionResult,
)

# A path is computed again rather than kept: its result need not wait for a checkpoint.
COMPUTE_PATH_TO_POSE = _topics(
    "compute_path_to_pose",
    nav2_msgs.ComputePathToPoseActionGoal,
    nav2_msgs.ComputePathToPoseActionFeedback,
    nav2_msgs.ComputePathToPoseActionResult,
    once=False,
)
COMPUTE_PATH_THROUGH_POSES = _topics(
    "compute_path_through_poses",
    nav2_msgs.ComputePathThroughPosesActionGoal,
    nav2_msgs.ComputePathThroughPosesActionFeedback,
    nav2_msgs.ComputePathThroughPosesActionResult,
    once=False,
)

# As for paths.
COMPUTE_ROUTE = _topics(
    "compute_route",
    nav2_servers.ComputeRouteActionGoal,
    nav2_servers.ComputeRouteActionFeedback,
    nav2_servers.ComputeRouteActionResult,
    once=False,
)
COMPUTE_AND_TRACK_ROUTE = _topics(
    "compute_and_track_route",
    nav2_servers.ComputeAndTrackRouteActionGoal,
    nav2_servers.ComputeAndTrackRouteActionFeedback,
    nav2_servers.ComputeAndTrackRouteActionResult,
)

FOLLOW_PATH = _topics(
    "controller_server/follow_path",
    nav2_motions.FollowPathActionGoal,
    nav2_motions.FollowPathActionFeedback,
    nav2_motions.FollowPathActionResult,
)
"""Clients call it ``follow_path``; topics of that name are those of a robot that follows paths itself."""

FOLLOW_OBJECT = _topics(
    "follow_object",
    nav2_motions.FollowObjectActionGoal,
    nav2_motions.FollowObjectActionFeedback,
    nav2_motions.FollowObjectActionResult,
)

DRIVE_ON_HEADING = _topics(
    "drive_on_heading",
    nav2_motions.DriveOnHeadingActionGoal,
    nav2_motions.DriveOnHeadingActionFeedback,
    nav2_motions.DriveOnHeadingActionResult,
)
SPIN = _topics("spin", nav2_motions.SpinActionGoal, nav2_motions.SpinActionFeedback, nav2_motions.SpinActionResult)
BACKUP = _topics(
    "backup", nav2_motions.BackUpActionGoal, nav2_motions.BackUpActionFeedback, nav2_motions.BackUpActionResult
)
WAIT = _topics("wait", nav2_motions.WaitActionGoal, nav2_motions.WaitActionFeedback, nav2_motions.WaitActionResult)

DOCK_ROBOT = _topics(
    "dock_robot",
    nav2_servers.DockRobotActionGoal,
    nav2_servers.DockRobotActionFeedback,
    nav2_servers.DockRobotActionResult,
)
UNDOCK_ROBOT = _topics(
    "undock_robot",
    nav2_servers.UndockRobotActionGoal,
    nav2_servers.UndockRobotActionFeedback,
    nav2_servers.UndockRobotActionResult,
)

NAV2_ACTIONS = tuple(each for each in tuple(globals().values()) if isinstance(each, Nav2ActionTopics))
"""The actions above."""

EXPLORE = _topics(
    "explore",
    explore_msgs.ExploreActionGoal,
    explore_msgs.ExploreActionFeedback,
    explore_msgs.ExploreActionResult,
)
"""Action of this project, of a robot that makes a map."""

PATH_GOALS = frozenset({COMPUTE_PATH_TO_POSE.goal.name, COMPUTE_PATH_THROUGH_POSES.goal.name})
"""Topics whose messages request paths, as calls of the path services do."""
