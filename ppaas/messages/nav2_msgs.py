"""``nav2_msgs``: actions of Nav2, one type per topic as in ROS 1, and speed limits."""

from enum import IntEnum
from typing import ClassVar

from msgspec import field

from ppaas.messages.actionlib_msgs import GoalID, GoalStatus
from ppaas.messages.base.message import Empty, Float32, Int16, Message, ServiceType, UInt8, UInt16, UInt32
from ppaas.messages.base.std_msgs import Duration, Header
from ppaas.messages.geometry_msgs import PoseStamped
from ppaas.messages.nav_msgs import Path


class FollowWaypointsError(IntEnum):
    """The ``error_code`` of a result, with the numbers of ``nav2_msgs/FollowWaypoints``."""

    NONE = 0
    UNKNOWN = 600
    TASK_EXECUTOR_FAILED = 601
    NO_VALID_WAYPOINTS = 602
    STOP_ON_MISSED_WAYPOINT = 603


class WaypointProgress(IntEnum):
    """The ``waypoint_status`` of a waypoint, with the numbers of ``nav2_msgs/WaypointStatus``."""

    PENDING = 0
    COMPLETED = 1
    SKIPPED = 2
    FAILED = 3


class WaypointStatus(Message):
    """``nav2_msgs/WaypointStatus``."""

    waypoint_status: int
    waypoint_index: int
    waypoint_pose: PoseStamped
    error_code: int = 0
    error_msg: str = ""


class FollowWaypointsGoal(Message):
    """``nav2_msgs/FollowWaypointsGoal``: the waypoints, the number of repetitions, and the index of the first one."""

    ros_order: ClassVar[tuple[str, ...]] = ("number_of_loops", "goal_index", "poses")

    poses: list[PoseStamped]
    number_of_loops: UInt32 = 0
    goal_index: UInt32 = 0


class FollowWaypointsActionGoal(Message):
    """``nav2_msgs/FollowWaypointsActionGoal``."""

    ros_order: ClassVar[tuple[str, ...]] = ("header", "goal_id", "goal")

    goal: FollowWaypointsGoal
    goal_id: GoalID = field(default_factory=GoalID)
    header: Header = field(default_factory=Header)


class FollowWaypointsFeedback(Message):
    """``nav2_msgs/FollowWaypointsFeedback``."""

    current_waypoint: int


class FollowWaypointsActionFeedback(Message):
    """``nav2_msgs/FollowWaypointsActionFeedback``."""

    header: Header
    status: GoalStatus
    feedback: FollowWaypointsFeedback


class FollowWaypointsResult(Message):
    """``nav2_msgs/FollowWaypointsResult``."""

    missed_waypoints: list[WaypointStatus] = field(default_factory=list)
    error_code: int = 0
    error_msg: str = ""


class FollowWaypointsActionResult(Message):
    """``nav2_msgs/FollowWaypointsActionResult``."""

    header: Header
    status: GoalStatus
    result: FollowWaypointsResult = field(default_factory=FollowWaypointsResult)


class NavigateToPoseGoal(Message):
    """``nav2_msgs/NavigateToPoseGoal``."""

    pose: PoseStamped
    behavior_tree: str = ""


class NavigateToPoseResult(Message):
    """``nav2_msgs/NavigateToPoseResult``."""

    error_code: UInt16 = 0
    error_msg: str = ""


class NavigateToPoseFeedback(Message):
    """``nav2_msgs/NavigateToPoseFeedback``; the remaining distance is along the path [m].

    The tracking errors, which Nav2 has since Lyrical, are the robot's distance from the path [m], positive on its left,
    and its heading against the path [rad].
    """

    current_pose: PoseStamped
    navigation_time: Duration
    estimated_time_remaining: Duration
    number_of_recoveries: Int16 = 0
    distance_remaining: Float32 = 0.0
    position_tracking_error: Float32 = 0.0
    heading_tracking_error: Float32 = 0.0


class NavigateToPoseActionFeedback(Message):
    """``nav2_msgs/NavigateToPoseActionFeedback``."""

    header: Header
    status: GoalStatus
    feedback: NavigateToPoseFeedback


class NavigateThroughPosesGoal(Message):
    """``nav2_msgs/NavigateThroughPosesGoal``: the robot passes all poses and stops at the last.

    ``poses`` is read from a ``nav_msgs/Goals``, too, as Nav2 has it since Kilted.
    """

    poses: list[PoseStamped]
    behavior_tree: str = ""


class NavigateThroughPosesActionGoal(Message, kw_only=True):
    """``nav2_msgs/NavigateThroughPosesActionGoal``."""

    header: Header = field(default_factory=Header)
    goal_id: GoalID = field(default_factory=GoalID)
    goal: NavigateThroughPosesGoal


class NavigateThroughPosesFeedback(NavigateToPoseFeedback):
    """``nav2_msgs/NavigateThroughPosesFeedback``; the last pose counts among those that remain."""

    number_of_poses_remaining: Int16 = 0
    waypoint_statuses: list[WaypointStatus] = field(default_factory=list)


class NavigateThroughPosesActionFeedback(Message):
    """``nav2_msgs/NavigateThroughPosesActionFeedback``."""

    header: Header
    status: GoalStatus
    feedback: NavigateThroughPosesFeedback


class NavigateThroughPosesResult(NavigateToPoseResult):
    """``nav2_msgs/NavigateThroughPosesResult``; the statuses belong to all poses of the goal, in its order."""

    waypoint_statuses: list[WaypointStatus] = field(default_factory=list)


class NavigateThroughPosesActionResult(Message):
    """``nav2_msgs/NavigateThroughPosesActionResult``."""

    header: Header
    status: GoalStatus
    result: NavigateThroughPosesResult


class ComputePathToPoseGoal(Message):
    """``nav2_msgs/ComputePathToPoseGoal``: the path begins at the robot, or at ``start`` if ``use_start``.

    It passes ``viapoints`` in order, which Nav2 has since Lyrical. They are last here, so that arguments in a list keep
    the order of earlier releases.
    """

    goal: PoseStamped
    start: PoseStamped
    planner_id: str = ""
    use_start: bool = False
    viapoints: list[PoseStamped] = field(default_factory=list)


class ComputePathToPoseActionGoal(Message, kw_only=True):
    """``nav2_msgs/ComputePathToPoseActionGoal``."""

    header: Header = field(default_factory=Header)
    goal_id: GoalID = field(default_factory=GoalID)
    goal: ComputePathToPoseGoal


class ComputePathToPoseActionFeedback(Message):
    """``nav2_msgs/ComputePathToPoseActionFeedback``, which is never published."""

    header: Header
    status: GoalStatus
    feedback: Empty


class ComputePathToPoseResult(Message):
    """``nav2_msgs/ComputePathToPoseResult``; the path is empty if there is an error."""

    path: Path
    planning_time: Duration
    error_code: UInt16 = 0
    error_msg: str = ""


class ComputePathToPoseActionResult(Message):
    """``nav2_msgs/ComputePathToPoseActionResult``."""

    header: Header
    status: GoalStatus
    result: ComputePathToPoseResult


class ComputePathThroughPosesGoal(Message):
    """``nav2_msgs/ComputePathThroughPosesGoal``: the path passes ``goals`` in order and ends at the last.

    ``goals`` is read from a ``nav_msgs/Goals``, too, as Nav2 has it since Kilted.
    """

    goals: list[PoseStamped]
    start: PoseStamped
    planner_id: str = ""
    use_start: bool = False


class ComputePathThroughPosesActionGoal(Message, kw_only=True):
    """``nav2_msgs/ComputePathThroughPosesActionGoal``."""

    header: Header = field(default_factory=Header)
    goal_id: GoalID = field(default_factory=GoalID)
    goal: ComputePathThroughPosesGoal


class ComputePathThroughPosesActionFeedback(Message):
    """``nav2_msgs/ComputePathThroughPosesActionFeedback``, which is never published."""

    header: Header
    status: GoalStatus
    feedback: Empty


class ComputePathThroughPosesResult(ComputePathToPoseResult):
    """``nav2_msgs/ComputePathThroughPosesResult``; the path is empty if there is an error.

    ``last_reached_index`` is the index of the goal at which the path ends, −1 without a path: no partial paths are
    planned. Nav2 has it since Lyrical.
    """

    last_reached_index: Int16 = -1


class ComputePathThroughPosesActionResult(Message):
    """``nav2_msgs/ComputePathThroughPosesActionResult``."""

    header: Header
    status: GoalStatus
    result: ComputePathThroughPosesResult


class SpeedLimit(Message):
    """``nav2_msgs/SpeedLimit``: a speed [m/s], or a percentage of the maximum speed; 0 removes the limit."""

    ros_order: ClassVar[tuple[str, ...]] = ("header", "percentage", "speed_limit")

    speed_limit: float
    percentage: bool = False
    header: Header = field(default_factory=Header)


class ClearEntireCostmapRequest(Message):
    """``nav2_msgs/ClearEntireCostmap`` request; ``plugins`` (since Lyrical) are the layers to clear, all if empty."""

    request: Empty = field(default_factory=Empty)
    plugins: list[str] = field(default_factory=list)


class ClearEntireCostmapResponse(Message):
    """``nav2_msgs/ClearEntireCostmap`` response; ``success`` replaced ``response`` in Lyrical."""

    response: Empty = field(default_factory=Empty)
    success: bool = True


ClearEntireCostmap = ServiceType("nav2_msgs/ClearEntireCostmap", ClearEntireCostmapRequest, ClearEntireCostmapResponse)


class IsPathValidRequest(Message):
    """``nav2_msgs/IsPathValid`` request.

    Nav2 has ``max_cost`` and ``consider_unknown_as_obstacle`` since Kilted, and the fields after them since Lyrical;
    the distance ahead of the robot up to which the path is checked is negative for all of it [m].
    """

    path: Path
    max_cost: UInt8 = 254
    consider_unknown_as_obstacle: bool = False
    layer_name: str = ""
    footprint: str = ""
    stop_at_first_collision: bool = True
    max_lookahead_distance: float = -1.0


class IsPathValidResponse(Message):
    """``nav2_msgs/IsPathValid`` response, with the indices of poses that are not free; ``success`` since Lyrical."""

    ros_order: ClassVar[tuple[str, ...]] = ("success", "is_valid", "invalid_pose_indices")

    is_valid: bool
    invalid_pose_indices: list[int]
    success: bool = True


IsPathValid = ServiceType("nav2_msgs/IsPathValid", IsPathValidRequest, IsPathValidResponse)

SERVICES = (ClearEntireCostmap, IsPathValid)
