"""``nav2_msgs``: actions by which a robot moves, from FollowPath to FollowObject, one type per topic as in ROS 1."""

from enum import IntEnum

from msgspec import field

from ppaas.messages.actionlib_msgs import GoalID, GoalStatus
from ppaas.messages.base.message import Empty, Float32, Message, UInt16, UInt32
from ppaas.messages.base.std_msgs import Duration, Header
from ppaas.messages.geometry_msgs import Point, Pose, PoseStamped, Quaternion
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
    CONTROLLER_TIMED_OUT = 107


class FollowPathGoal(Message):
    """``nav2_msgs/FollowPathGoal``: the path in the map frame, from the robot to the goal.

    Nav2 has ``progress_checker_id`` since Jazzy, and ``path_handler_id`` since Lyrical.
    """

    path: Path
    controller_id: str = ""
    goal_checker_id: str = ""
    progress_checker_id: str = ""
    path_handler_id: str = ""


class FollowPathActionGoal(Message, kw_only=True):
    """``nav2_msgs/FollowPathActionGoal``."""

    header: Header = field(default_factory=Header)
    goal_id: GoalID = field(default_factory=GoalID)
    goal: FollowPathGoal


class TrackingFeedback(Message):
    """``nav2_msgs/TrackingFeedback``: where the robot is on its path.

    The errors are the robot's distance from the path [m], positive on its left, and its heading against it [rad];
    ``distance_to_goal`` is along the straight line [m], ``remaining_path_length`` along the path [m].
    """

    header: Header
    position_tracking_error: Float32
    heading_tracking_error: Float32
    current_path_index: UInt32
    robot_pose: PoseStamped
    distance_to_goal: Float32
    speed: Float32
    remaining_path_length: Float32


def no_tracking() -> TrackingFeedback:
    """Return the feedback of a robot that reports no errors."""
    nowhere = PoseStamped(Header(), Pose(Point(0.0, 0.0), Quaternion(z=0.0, w=1.0)))
    return TrackingFeedback(Header(), 0.0, 0.0, 0, nowhere, 0.0, 0.0, 0.0)


class FollowPathFeedback(Message):
    """``nav2_msgs/FollowPathFeedback``: the rest of the path [m] and the speed [m/s].

    ``tracking_feedback`` replaced both in Lyrical.
    """

    distance_to_goal: Float32
    speed: Float32
    tracking_feedback: TrackingFeedback = field(default_factory=no_tracking)


class FollowPathActionFeedback(Message):
    """``nav2_msgs/FollowPathActionFeedback``; the text of the status says why the robot stands."""

    header: Header
    status: GoalStatus
    feedback: FollowPathFeedback


class FollowPathResult(Message):
    """``nav2_msgs/FollowPathResult``."""

    error_code: UInt16 = 0
    error_msg: str = ""
    result: Empty = field(default_factory=Empty)


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


class DriveOnHeadingGoal(Message):
    """``nav2_msgs/DriveOnHeadingGoal``: the distance ``target.x`` [m] at a speed [m/s] of the same sign, in a time."""

    target: Point
    speed: Float32
    time_allowance: Duration
    disable_collision_checks: bool = False


class DriveOnHeadingActionGoal(Message, kw_only=True):
    """``nav2_msgs/DriveOnHeadingActionGoal``."""

    header: Header = field(default_factory=Header)
    goal_id: GoalID = field(default_factory=GoalID)
    goal: DriveOnHeadingGoal


class DriveOnHeadingFeedback(BackUpFeedback):
    """``nav2_msgs/DriveOnHeadingFeedback`` [m]."""


class DriveOnHeadingActionFeedback(Message):
    """``nav2_msgs/DriveOnHeadingActionFeedback``."""

    header: Header
    status: GoalStatus
    feedback: DriveOnHeadingFeedback


class DriveOnHeadingResult(SpinResult):
    """``nav2_msgs/DriveOnHeadingResult``."""


class DriveOnHeadingActionResult(Message):
    """``nav2_msgs/DriveOnHeadingActionResult``."""

    header: Header
    status: GoalStatus
    result: DriveOnHeadingResult


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


# -- FollowObject ------------------------------------------------------------------------------------------------------


class FollowObjectError(IntEnum):
    """The ``error_code`` of a result, with the numbers of ``nav2_msgs/FollowObject``."""

    NONE = 0
    TF_ERROR = 901
    FAILED_TO_DETECT_OBJECT = 902
    FAILED_TO_CONTROL = 903
    TIMEOUT = 904
    UNKNOWN = 999


class FollowObjectPhase(IntEnum):
    """The ``state`` of feedback."""

    NONE = 0
    INITIAL_PERCEPTION = 1
    CONTROLLING = 2
    STOPPING = 3
    RETRY = 4


class FollowObjectGoal(Message):
    """``nav2_msgs/FollowObjectGoal``: the topic of the object's poses, or its frame; a time, 0 for no limit."""

    pose_topic: str
    tracked_frame: str
    max_duration: Duration


class FollowObjectFeedback(Message):
    """``nav2_msgs/FollowObjectFeedback``."""

    state: UInt16
    following_time: Duration
    num_retries: UInt16 = 0


class FollowObjectResult(Message):
    """``nav2_msgs/FollowObjectResult``."""

    total_elapsed_time: Duration
    error_code: UInt16 = 0
    num_retries: UInt16 = 0
    error_msg: str = ""


class FollowObjectActionGoal(Message, kw_only=True):
    """``nav2_msgs/FollowObjectActionGoal``."""

    header: Header = field(default_factory=Header)
    goal_id: GoalID = field(default_factory=GoalID)
    goal: FollowObjectGoal


class FollowObjectActionFeedback(Message):
    """``nav2_msgs/FollowObjectActionFeedback``."""

    header: Header
    status: GoalStatus
    feedback: FollowObjectFeedback


class FollowObjectActionResult(Message):
    """``nav2_msgs/FollowObjectActionResult``."""

    header: Header
    status: GoalStatus
    result: FollowObjectResult
