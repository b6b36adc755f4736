"""``nav2_msgs``: the action FollowPath, one type per topic as in ROS 1."""

from enum import IntEnum

from msgspec import field

from ppaas.messages.actionlib_msgs import GoalID, GoalStatus
from ppaas.messages.base.message import Float32, Message, UInt16
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.nav_msgs import Path

PACKAGE = "nav2_msgs"
"""ROS package of these messages."""


class FollowPathError(IntEnum):
    """The ``error_code`` of a result, with the numbers of ``nav2_msgs/FollowPath``."""

    NONE = 0
    UNKNOWN = 100
    INVALID_CONTROLLER = 101
    TF_ERROR = 102
    INVALID_PATH = 103
    PATIENCE_EXCEEDED = 104
    FAILED_TO_MAKE_PROGRESS = 105
    NO_VALID_CONTROL = 106


class FollowPathGoal(Message):
    """``nav2_msgs/FollowPathGoal``: the path in the map frame, from the robot to the goal."""

    path: Path
    controller_id: str = ""
    goal_checker_id: str = ""


class FollowPathActionGoal(Message):
    """``nav2_msgs/FollowPathActionGoal``."""

    header: Header
    goal_id: GoalID
    goal: FollowPathGoal


class FollowPathFeedback(Message):
    """``nav2_msgs/FollowPathFeedback``: the rest of the path [m] and the speed [m/s]."""

    distance_to_goal: Float32
    speed: Float32


class FollowPathActionFeedback(Message):
    """``nav2_msgs/FollowPathActionFeedback``; the text of the status says why the robot stands."""

    header: Header
    status: GoalStatus
    feedback: FollowPathFeedback


class FollowPathResult(Message):
    """``nav2_msgs/FollowPathResult``."""

    error_code: UInt16 = 0
    error_msg: str = ""


class FollowPathActionResult(Message):
    """``nav2_msgs/FollowPathActionResult``."""

    header: Header
    status: GoalStatus
    result: FollowPathResult = field(default_factory=FollowPathResult)
