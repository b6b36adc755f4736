"""``nav2_msgs``: actions of the route server and of the docking server, one type per topic as in ROS 1."""

from enum import IntEnum

from msgspec import field

from ppaas.messages.actionlib_msgs import GoalID, GoalStatus
from ppaas.messages.base.message import Empty, Float32, Message, UInt16
from ppaas.messages.base.std_msgs import Duration, Header
from ppaas.messages.geometry_msgs import Point, Pose, PoseStamped, Quaternion
from ppaas.messages.nav_msgs import Path

PACKAGE = "nav2_msgs"
"""ROS package of these messages."""


class RouteError(IntEnum):
    """The ``error_code`` of a result, with the numbers of ``nav2_msgs/ComputeAndTrackRoute``."""

    NONE = 0
    UNKNOWN = 400
    TF_ERROR = 401
    NO_VALID_GRAPH = 402
    INDETERMINANT_NODES_ON_GRAPH = 403
    TIMEOUT = 404
    NO_VALID_ROUTE = 405
    OPERATION_FAILED = 406
    INVALID_EDGE_SCORER_USE = 407


class RouteNode(Message):
    """``nav2_msgs/RouteNode``: a place of the graph, in the frame of the route."""

    nodeid: UInt16
    position: Point


class RouteEdge(Message):
    """``nav2_msgs/RouteEdge``: a straight part of the graph, in the direction of driving."""

    edgeid: UInt16
    start: Point
    end: Point


class Route(Message):
    """``nav2_msgs/Route``: the nodes in order, the edges between them, and the length of all [m] as the cost."""

    header: Header
    route_cost: Float32
    nodes: list[RouteNode]
    edges: list[RouteEdge]


class ComputeRouteGoal(Message):
    """``nav2_msgs/ComputeRouteGoal``: from node to node or, with ``use_poses``, between the nodes nearest to poses.

    With ``use_poses`` but without ``use_start`` the route begins at the robot.
    """

    start_id: UInt16
    start: PoseStamped
    goal_id: UInt16
    goal: PoseStamped
    use_start: bool = False
    use_poses: bool = False


class ComputeRouteResult(Message):
    """``nav2_msgs/ComputeRouteResult``; the path is empty if there is an error."""

    planning_time: Duration
    path: Path
    route: Route
    error_code: UInt16 = 0
    error_msg: str = ""


class ComputeRouteActionGoal(Message, kw_only=True):
    """``nav2_msgs/ComputeRouteActionGoal``."""

    header: Header = field(default_factory=Header)
    goal_id: GoalID = field(default_factory=GoalID)
    goal: ComputeRouteGoal


class ComputeRouteActionFeedback(Message):
    """``nav2_msgs/ComputeRouteActionFeedback``, which is never published."""

    header: Header
    status: GoalStatus
    feedback: Empty


class ComputeRouteActionResult(Message):
    """``nav2_msgs/ComputeRouteActionResult``."""

    header: Header
    status: GoalStatus
    result: ComputeRouteResult


class ComputeAndTrackRouteGoal(ComputeRouteGoal):
    """``nav2_msgs/ComputeAndTrackRouteGoal``: the same as of ComputeRoute."""


class ComputeAndTrackRouteFeedback(Message):
    """``nav2_msgs/ComputeAndTrackRouteFeedback``: between which nodes the robot is, and the route.

    Behind the last edge ``next_node_id`` and ``current_edge_id`` are 0.
    """

    last_node_id: UInt16
    next_node_id: UInt16
    current_edge_id: UInt16
    route: Route
    path: Path
    operations_triggered: list[str] = field(default_factory=list)
    rerouted: bool = False


class ComputeAndTrackRouteResult(Message):
    """``nav2_msgs/ComputeAndTrackRouteResult``."""

    execution_duration: Duration
    error_code: UInt16 = 0
    error_msg: str = ""


class ComputeAndTrackRouteActionGoal(Message, kw_only=True):
    """``nav2_msgs/ComputeAndTrackRouteActionGoal``."""

    header: Header = field(default_factory=Header)
    goal_id: GoalID = field(default_factory=GoalID)
    goal: ComputeAndTrackRouteGoal


class ComputeAndTrackRouteActionFeedback(Message):
    """``nav2_msgs/ComputeAndTrackRouteActionFeedback``."""

    header: Header
    status: GoalStatus
    feedback: ComputeAndTrackRouteFeedback


class ComputeAndTrackRouteActionResult(Message):
    """``nav2_msgs/ComputeAndTrackRouteActionResult``."""

    header: Header
    status: GoalStatus
    result: ComputeAndTrackRouteResult


# -- docking -----------------------------------------------------------------------------------------------------------


class DockError(IntEnum):
    """The ``error_code`` of a result, with the numbers of ``nav2_msgs/DockRobot`` and ``nav2_msgs/UndockRobot``."""

    NONE = 0
    DOCK_NOT_IN_DB = 901
    DOCK_NOT_VALID = 902
    FAILED_TO_STAGE = 903
    FAILED_TO_DETECT_DOCK = 904
    FAILED_TO_CONTROL = 905
    FAILED_TO_CHARGE = 906
    TIMEOUT = 907
    UNKNOWN = 999


class DockPhase(IntEnum):
    """The ``state`` of feedback."""

    NONE = 0
    NAV_TO_STAGING_POSE = 1
    INITIAL_PERCEPTION = 2
    CONTROLLING = 3
    WAIT_FOR_CHARGE = 4
    RETRY = 5


def nowhere() -> PoseStamped:
    """Return a pose without a frame."""
    return PoseStamped(Header(), Pose(Point(0.0, 0.0), Quaternion(z=0.0, w=1.0)))


class DockRobotGoal(Message):
    """``nav2_msgs/DockRobotGoal``: a dock of the map by its name, or with ``use_dock_id`` false by its pose.

    ``max_staging_time`` is the time for the way to the staging pose [s].
    """

    use_dock_id: bool = True
    dock_id: str = ""
    dock_pose: PoseStamped = field(default_factory=nowhere)
    dock_type: str = ""
    max_staging_time: Float32 = 1000.0
    navigate_to_staging_pose: bool = True


class DockRobotFeedback(Message):
    """``nav2_msgs/DockRobotFeedback``."""

    state: UInt16
    docking_time: Duration
    num_retries: UInt16 = 0


class DockRobotResult(Message):
    """``nav2_msgs/DockRobotResult``."""

    success: bool = True
    error_code: UInt16 = 0
    num_retries: UInt16 = 0
    error_msg: str = ""


class DockRobotActionGoal(Message, kw_only=True):
    """``nav2_msgs/DockRobotActionGoal``."""

    header: Header = field(default_factory=Header)
    goal_id: GoalID = field(default_factory=GoalID)
    goal: DockRobotGoal = field(default_factory=DockRobotGoal)


class DockRobotActionFeedback(Message):
    """``nav2_msgs/DockRobotActionFeedback``."""

    header: Header
    status: GoalStatus
    feedback: DockRobotFeedback


class DockRobotActionResult(Message):
    """``nav2_msgs/DockRobotActionResult``."""

    header: Header
    status: GoalStatus
    result: DockRobotResult


class UndockRobotGoal(Message):
    """``nav2_msgs/UndockRobotGoal``: the type of the dock, empty for the one that the robot stands at; a time [s]."""

    dock_type: str = ""
    max_undocking_time: Float32 = 30.0


class UndockRobotFeedback(Message):
    """``nav2_msgs/UndockRobotFeedback``, without fields."""


class UndockRobotResult(Message):
    """``nav2_msgs/UndockRobotResult``."""

    success: bool = True
    error_code: UInt16 = 0
    error_msg: str = ""


class UndockRobotActionGoal(Message, kw_only=True):
    """``nav2_msgs/UndockRobotActionGoal``."""

    header: Header = field(default_factory=Header)
    goal_id: GoalID = field(default_factory=GoalID)
    goal: UndockRobotGoal = field(default_factory=UndockRobotGoal)


class UndockRobotActionFeedback(Message):
    """``nav2_msgs/UndockRobotActionFeedback``."""

    header: Header
    status: GoalStatus
    feedback: UndockRobotFeedback


class UndockRobotActionResult(Message):
    """``nav2_msgs/UndockRobotActionResult``."""

    header: Header
    status: GoalStatus
    result: UndockRobotResult
