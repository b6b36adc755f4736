"""Topics of a clone and the delivery policy of each, in one table.

Nodes, containers, endpoints, agents and robots all look up the policy of a topic here. ``Topic`` explains the columns.
"""

from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray
from ppaas.messages.base.map_msgs import OccupancyGridUpdate
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Bool, Float64, String
from ppaas.messages.fleet.traffic import TrafficGrants, TrafficReport, TrafficState
from ppaas.messages.geometry_msgs import (
    Polygon,
    PolygonStamped,
    PoseArray,
    PoseStamped,
    PoseWithCovarianceStamped,
    Twist,
)
from ppaas.messages.health.diagnostic_msgs import DiagnosticArray
from ppaas.messages.health.stops import StopState
from ppaas.messages.move_base_msgs import MoveBaseActionFeedback, MoveBaseActionGoal, MoveBaseActionResult
from ppaas.messages.nav2_motions import (
    FollowPathActionFeedback,
    FollowPathActionGoal,
    FollowPathActionResult,
)
from ppaas.messages.nav2_msgs import (
    FollowWaypointsActionFeedback,
    FollowWaypointsActionGoal,
    FollowWaypointsActionResult,
    NavigateToPoseActionFeedback,
    SpeedLimit,
)
from ppaas.messages.nav_msgs import MapMetaData, OccupancyGrid, Odometry, Path
from ppaas.messages.octomap_msgs import Octomap
from ppaas.messages.operators.teleoperation import TeleopCommand, TeleopState
from ppaas.messages.people_coordination import FollowStatus, GoalUpdate, PeopleReport, PeopleState, SensorView
from ppaas.messages.people_msgs import People, PositionMeasurementArray
from ppaas.messages.ppaas_msgs import NodeHomes, RobotStates
from ppaas.messages.sensor_msgs import (
    BatteryState,
    CameraInfo,
    CompressedImage,
    FluidPressure,
    Image,
    LaserScan,
    MultiEchoLaserScan,
    PointCloud2,
)
from ppaas.messages.tf2_msgs import TFMessage, merged
from ppaas.messages.tf2_web_republisher import (
    TFSubscriptionActionFeedback,
    TFSubscriptionActionGoal,
    TFSubscriptionActionResult,
)
from ppaas.messages.vision_msgs import Detection3DArray
from ppaas.nodes.base import Topic
from ppaas.nodes.nav2_actions import EXPLORE, NAV2_ACTIONS

# fmt: off
# -- sensors -----------------------------------------------------------------------------------------------------------

SCAN = Topic("scan", LaserScan, stream=True, depth=1, robot_only=True)
ECHOES = Topic("echoes", MultiEchoLaserScan, stream=True, depth=1, robot_only=True)
ODOM = Topic("odom", Odometry, stream=True, depth=1, robot_only=True)
TF = Topic("tf", TFMessage, stream=True, depth=50, robot_only=True, many_publishers=True)
TF_STATIC = Topic("tf_static", TFMessage, latched=True, stream=True, lasting=True, robot_only=True,
                  many_publishers=True, merge=merged)
DEPTH_IMAGE = Topic("camera/depth/image_raw", Image, stream=True, local=True)
COMPRESSED_DEPTH_IMAGE = Topic("camera/depth/image_raw/compressedDepth", CompressedImage, stream=True, local=True)
DEPTH_CAMERA_INFO = Topic("camera/depth/camera_info", CameraInfo, local=True)
CLOUD_IN = Topic("cloud_in", PointCloud2, stream=True, depth=1, local=True)
PEOPLE = Topic("people", People, stream=True)
DETECTIONS = Topic("detections", Detection3DArray, stream=True)
BAROMETER = Topic("barometer", FluidPressure, stream=True, depth=1)

# -- docks -------------------------------------------------------------------------------------------------------------

BATTERY_STATE = Topic("battery_state", BatteryState, stream=True)
DETECTED_DOCK_POSE = Topic("detected_dock_pose", PoseStamped, stream=True, depth=1)
DOCK_STATUS = Topic("docking_server/status", String, latched=True, stream=True, depth=1, robot_only=True)
LIFT = Topic("lift", Bool, latched=True, lasting=True, depth=1, robot_only=True)
LIFT_STATE = Topic("lift_state", Bool, stream=True, depth=1, robot_only=True)

# -- people ------------------------------------------------------------------------------------------------------------

LEG_MEASUREMENTS = Topic("leg_tracker_measurements", PositionMeasurementArray, stream=True, robot_only=True)
TORSO_MEASUREMENTS = Topic("torso_detector/measurements", PositionMeasurementArray, stream=True, robot_only=True)
LEG_VIEW = Topic("leg_detector/view", SensorView, latched=True, depth=1, robot_only=True)
TORSO_VIEW = Topic("torso_detector/view", SensorView, latched=True, depth=1, robot_only=True)
PEOPLE_MEASUREMENTS = Topic("people_tracker_measurements", PositionMeasurementArray, stream=True, robot_only=True)
PEOPLE_REPORT = Topic("people_tracker/report", PeopleReport, stream=True, robot_only=True)
PEOPLE_TRACKER_STATUS = Topic("people_tracker/status", String, latched=True, stream=True, depth=1, robot_only=True)
PEOPLE_STATE = Topic("people_coordinator/state", PeopleState, stream=True, depth=1)
FOLLOW_STATUS = Topic("follow_person/status", FollowStatus, latched=True, stream=True, depth=1)

# -- map server and localization ---------------------------------------------------------------------------------------

MAP = Topic("map", OccupancyGrid, latched=True, depth=1, lasting=True)
INITIAL_POSE = Topic("initialpose", PoseWithCovarianceStamped)
AMCL_POSE = Topic("amcl_pose", PoseWithCovarianceStamped, stream=True, shared=True)
PARTICLE_CLOUD = Topic("particlecloud", PoseArray, stream=True, depth=1)
ROBOT_DESCRIPTION = Topic("robot_description", String, latched=True, depth=1)
AMCL_STATUS = Topic("amcl/status", String, latched=True, stream=True, depth=1, robot_only=True)

# -- mapping -----------------------------------------------------------------------------------------------------------

MAP_METADATA = Topic("map_metadata", MapMetaData, latched=True, depth=1)
MAP_UPDATES = Topic("map_updates", OccupancyGridUpdate, depth=100, lasting=True)
SLAM_POSE = Topic("pose", PoseWithCovarianceStamped, stream=True)
ENTROPY = Topic("entropy", Float64, stream=True, depth=1)
GRID_SLAM_STATUS = Topic("grid_slam/status", String, latched=True, stream=True, depth=1, robot_only=True)
SHARED_POSE = Topic("grid_slam/shared_pose", PoseWithCovarianceStamped, stream=True, robot_only=True)
KEY_FRAMES = Topic("key_frames", Path, latched=True, stream=True, depth=1, robot_only=True)
OCTOMAP_BINARY = Topic("octomap_binary", Octomap, latched=True, stream=True, depth=1, repeated=True)
OCTOMAP_FULL = OCTOMAP_BINARY._replace(name="octomap_full")
PROJECTED_MAP = OCTOMAP_BINARY._replace(name="projected_map", type=OccupancyGrid)
OCTOMAP_SERVER_STATUS = GRID_SLAM_STATUS._replace(name="octomap_server/status")

# -- Move Base ---------------------------------------------------------------------------------------------------------

SIMPLE_GOAL = Topic("move_base_simple/goal", PoseStamped, many_publishers=True)
GOAL_POSE = Topic("goal_pose", PoseStamped)
MOVE_BASE_GOAL = Topic("move_base/goal", MoveBaseActionGoal, many_publishers=True)
GOAL_UPDATE = Topic("goal_update", PoseStamped, stream=True, depth=1)
DYNAMIC_POSE = Topic("dynamic_pose", PoseStamped, stream=True, depth=1)
MOVE_BASE_GOAL_UPDATE = Topic("move_base/goal_update", GoalUpdate, stream=True, depth=1)
MOVE_BASE_CANCEL = Topic("move_base/cancel", GoalID, many_publishers=True)
MOVE_BASE_CURRENT_GOAL = Topic("move_base/current_goal", PoseStamped)
MOVE_BASE_STATUS = Topic("move_base/status", GoalStatusArray, stream=True)
MOVE_BASE_FEEDBACK = Topic("move_base/feedback", MoveBaseActionFeedback, stream=True)
MOVE_BASE_RESULT = Topic("move_base/result", MoveBaseActionResult, published_once=True, depth=1000, lasting=True)
NAVIGATE_TO_POSE_FEEDBACK = Topic("navigate_to_pose/feedback", NavigateToPoseActionFeedback, stream=True)
CMD_VEL = Topic("cmd_vel", Twist, stream=True, depth=1, expiry=0.5, urgent=True)
PLAN = Topic("plan", Path, stream=True, depth=1)
LOCAL_PLAN = Topic("local_plan", Path, stream=True, depth=1)
ROBOTS = Topic("robots", RobotStates, stream=True)
SPEED_LIMIT = Topic("speed_limit", SpeedLimit)
STOP_STATE = Topic("stop/state", StopState, latched=True, depth=1, lasting=True, robot_only=True)
TELEOP_CMD = Topic("teleop_cmd", TeleopCommand, stream=True, depth=1)
TELEOP_STATE = Topic("teleop_state", TeleopState, stream=True, depth=1, expiry=1.0, urgent=True, robot_only=True)

# -- traffic of the robots of a map -----------------------------------------------------------------------------------

TRAFFIC_REPORT = Topic("traffic/report", TrafficReport, stream=True, depth=1, robot_only=True)
TRAFFIC_GRANTS = Topic("traffic/grants", TrafficGrants, stream=True, depth=1)
TRAFFIC_STATE = Topic("traffic/state", TrafficState, latched=True, stream=True, depth=1)

# -- paths that a robot follows itself ---------------------------------------------------------------------------------

FOLLOW_PATH_GOAL = Topic("follow_path/goal", FollowPathActionGoal, latched=True, depth=1, lasting=True)
FOLLOW_PATH_CANCEL = Topic("follow_path/cancel", GoalID)
FOLLOW_PATH_FEEDBACK = Topic("follow_path/feedback", FollowPathActionFeedback, stream=True, depth=1, robot_only=True)
FOLLOW_PATH_RESULT = Topic("follow_path/result", FollowPathActionResult, robot_only=True)

# -- costmaps of Move Base, by the names of Nav2 and of ROS 1 ----------------------------------------------------------

GLOBAL_COSTMAP = Topic("global_costmap/costmap", OccupancyGrid, latched=True, stream=True, depth=1, repeated=True)
LOCAL_COSTMAP = GLOBAL_COSTMAP._replace(name="local_costmap/costmap")
MOVE_BASE_GLOBAL_COSTMAP = GLOBAL_COSTMAP._replace(name="move_base/global_costmap/costmap")
MOVE_BASE_LOCAL_COSTMAP = GLOBAL_COSTMAP._replace(name="move_base/local_costmap/costmap")
LOCAL_FOOTPRINT = GLOBAL_COSTMAP._replace(name="local_costmap/published_footprint", type=PolygonStamped)
LOCAL_LOAD = Topic("local_costmap/footprint", Polygon)
GLOBAL_LOAD = LOCAL_LOAD._replace(name="global_costmap/footprint")
MOVE_BASE_FOOTPRINT = LOCAL_FOOTPRINT._replace(name="move_base/local_costmap/footprint")

# -- waypoint follower -------------------------------------------------------------------------------------------------

WAYPOINTS_GOAL = Topic("follow_waypoints/goal", FollowWaypointsActionGoal, many_publishers=True)
WAYPOINTS_CANCEL = Topic("follow_waypoints/cancel", GoalID, many_publishers=True)
WAYPOINTS_STATUS = Topic("follow_waypoints/status", GoalStatusArray, stream=True)
WAYPOINTS_FEEDBACK = Topic("follow_waypoints/feedback", FollowWaypointsActionFeedback, stream=True)
WAYPOINTS_RESULT = Topic("follow_waypoints/result", FollowWaypointsActionResult, published_once=True, depth=1000,
                         lasting=True)

# -- TF republisher, node monitor and diagnostics ----------------------------------------------------------------------

TF_REPUBLISHER_GOAL = Topic("tf2_web_republisher/goal", TFSubscriptionActionGoal, many_publishers=True)
TF_REPUBLISHER_CANCEL = Topic("tf2_web_republisher/cancel", GoalID, many_publishers=True)
# Latched: a client learns at once that the server is up, and no timer has to repeat the status.
TF_REPUBLISHER_STATUS = Topic("tf2_web_republisher/status", GoalStatusArray, latched=True)
TF_REPUBLISHER_FEEDBACK = Topic("tf2_web_republisher/feedback", TFSubscriptionActionFeedback)
TF_REPUBLISHER_RESULT = Topic("tf2_web_republisher/result", TFSubscriptionActionResult)
NODE_HOMES = Topic("node_monitor/homes", NodeHomes, latched=True)
DIAGNOSTICS = Topic("diagnostics", DiagnosticArray, stream=True, robot_only=True)
# fmt: on

TOPICS = {topic.name: topic for topic in tuple(globals().values()) if isinstance(topic, Topic)} | {
    topic.name: topic for action in (*NAV2_ACTIONS, EXPLORE) for topic in action
}
"""The topics above, and the topics of the actions of Nav2 and of `explore`, by their names."""

CLIENT_TOPIC = Topic("", Message)
"""Policy of a topic that is not in the table, such as one that a client advertises."""

SCAN_RATE = 80e3
"""Data rate of a laser of 360 beams at 10 Hz, as JSON [bytes/s]."""

ODOM_RATE = 20e3
"""Data rate of odometry at 20 Hz, as JSON with covariances [bytes/s]."""


def policy_of(name: str) -> Topic:
    """Return the delivery policy of a topic by its name, or ``CLIENT_TOPIC`` if the clone does not define it."""
    return TOPICS.get(name, CLIENT_TOPIC)
