"""``nav2_msgs``: the actions FollowPath, Spin, BackUp and Wait, one type per topic as in ROS 1."""

from enum import IntEnum

from msgspec import field

from ppaas.messages.actionlib_msgs import GoalID, GoalStatus
from ppaas.messages.base.message import Float32, Message, UInt16
from ppaas.messages.base.std_msgs import Duration, Header
from ppaas.messages.geometry_msgs import Point
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


class SpinGoal(Message):
    """``nav2_msgs/SpinGoal``: a turn to the left [rad], in at most a time."""

    target_yaw: Float32
    time_allowance: Duration
    disable_collision_checks: bool = False


class SpinActionGoal(Message, kw_only=True):
    """``nav2_msgs/SpinActionGoal``."""

    header: Header = field(default_factory=Header)
    goal_id: GoalID = field(default_factory=GoalID)
    goal: SpinGoal


class SpinFeedback(Message):
    """``nav2_msgs/SpinFeedback`` [rad]."""

    angular_distance_traveled: Float32


class SpinActionFeedback(Message):
    """``nav2_msgs/SpinActionFeedback``."""

    header: Header
    status: GoalStatus
    feedback: SpinFeedback


class SpinResult(Message):
    """``nav2_msgs/SpinResult``."""

    total_elapsed_time: Duration
    error_code: UInt16 = 0
    error_msg: str = ""


class SpinActionResult(Message):
    """``nav2_msgs/SpinActionResult``."""

    header: Header
    status: GoalStatus
    result: SpinResult


class BackUpGoal(Message):
    """``nav2_msgs/BackUpGoal``: the distance ``target.x`` [m] at a speed [m/s], in a time; signs do not count."""

    target: Point
    speed: Float32
    time_allowance: Duration
    disable_collision_checks: bool = False


class BackUpActionGoal(Message, kw_only=True):
    """``nav2_msgs/BackUpActionGoal``."""

    header: Header = field(default_factory=Header)
    goal_id: GoalID = field(default_factory=GoalID)
    goal: BackUpGoal


class BackUpFeedback(Message):
    """``nav2_msgs/BackUpFeedback`` [m]."""

    distance_traveled: Float32


class BackUpActionFeedback(Message):
    """``nav2_msgs/BackUpActionFeedback``."""

    header: Header
    status: GoalStatus
    feedback: BackUpFeedback


class BackUpResult(SpinResult):
    """``nav2_msgs/BackUpResult``."""


class BackUpActionResult(Message):
    """``nav2_msgs/BackUpActionResult``."""

    header: Header
    status: GoalStatus
    result: BackUpResult


class WaitGoal(Message):
    """``nav2_msgs/WaitGoal``."""

    time: Duration


class WaitActionGoal(Message, kw_only=True):
    """``nav2_msgs/WaitActionGoal``."""

    header: Header = field(default_factory=Header)
    goal_id: GoalID = field(default_factory=GoalID)
    goal: WaitGoal


class WaitFeedback(Message):
    """``nav2_msgs/WaitFeedback``."""

    time_left: Duration


class WaitActionFeedback(Message):
    """``nav2_msgs/WaitActionFeedback``."""

    header: Header
    status: GoalStatus
    feedback: WaitFeedback


class WaitResult(SpinResult):
    """``nav2_msgs/WaitResult``."""


class WaitActionResult(Message):
    """``nav2_msgs/WaitActionResult``."""

    header: Header
    status: GoalStatus
    result: WaitResult
