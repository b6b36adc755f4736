"""Topics, services and actions that a bridge carries, by their names in the cloud and at the robot."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from ppaas.wire.ros.graph import LATCHED, SENSOR, Qos

IMAGE_PERIOD, CLOUD_PERIOD, JOINTS_PERIOD = 0.1, 0.2, 0.1
"""Least time between two depth images, point clouds and states of joints that are carried [s]."""


@dataclass(frozen=True, slots=True)
class UpTopic:
    """Topic that the robot publishes.

    Parameters
    ----------
    cloud : str
        Name in the cloud.
    type : str
        Type of its messages.
    names : tuple of str
        Names in the robot's namespace, the preferred one first.
    only : bool
        Whether the only topic of this type in the namespace is taken, whatever its name.
    reliable : bool
        Whether no message may be lost, as of goals.
    clone : bool
        Whether it is carried only if the clone has the topic; else it is advertised to other clients.
    period : float
        Least time between two messages that are carried [s].
    """

    cloud: str
    type: str
    names: tuple[str, ...]
    only: bool = False
    reliable: bool = False
    clone: bool = True
    period: float = 0.0


ODOMETRY: Final = UpTopic("odom", "nav_msgs/msg/Odometry", ("odom", "odometry/filtered"), only=True)
SCAN: Final = UpTopic("scan", "sensor_msgs/msg/LaserScan", ("scan",), only=True)

_DEPTH = "camera/depth"
UP: Final = (
    ODOMETRY,
    SCAN,
    UpTopic("goal_pose", "geometry_msgs/msg/PoseStamped", ("goal_pose",), reliable=True),
    UpTopic("initialpose", "geometry_msgs/msg/PoseWithCovarianceStamped", ("initialpose",), reliable=True),
    UpTopic(
        f"{_DEPTH}/image_raw",
        "sensor_msgs/msg/Image",
        (f"{_DEPTH}/image_raw", f"{_DEPTH}/image_rect_raw"),
        period=IMAGE_PERIOD,
    ),
    UpTopic(
        f"{_DEPTH}/image_raw/compressedDepth",
        "sensor_msgs/msg/CompressedImage",
        (f"{_DEPTH}/image_raw/compressedDepth", f"{_DEPTH}/image_rect_raw/compressedDepth"),
        period=IMAGE_PERIOD,
    ),
    UpTopic(f"{_DEPTH}/camera_info", "sensor_msgs/msg/CameraInfo", (f"{_DEPTH}/camera_info",), period=IMAGE_PERIOD),
    UpTopic(
        "cloud_in",
        "sensor_msgs/msg/PointCloud2",
        ("cloud_in", "points", f"{_DEPTH}/points", f"{_DEPTH}/color/points"),
        period=CLOUD_PERIOD,
    ),
    UpTopic("people", "people_msgs/msg/People", ("people",)),
    UpTopic("detections", "vision_msgs/msg/Detection3DArray", ("detections",)),
    UpTopic("goal_update", "geometry_msgs/msg/PoseStamped", ("goal_update",)),
    UpTopic("dynamic_pose", "geometry_msgs/msg/PoseStamped", ("dynamic_pose",)),
    UpTopic("speed_limit", "nav2_msgs/msg/SpeedLimit", ("speed_limit",), reliable=True),
    UpTopic("diagnostics", "diagnostic_msgs/msg/DiagnosticArray", ("diagnostics",)),
    UpTopic("joint_states", "sensor_msgs/msg/JointState", ("joint_states",), clone=False, period=JOINTS_PERIOD),
    UpTopic("battery_state", "sensor_msgs/msg/BatteryState", ("battery_state", "battery"), clone=False, period=1.0),
    UpTopic("barometer", "sensor_msgs/msg/FluidPressure", ("barometer", "air_pressure"), period=0.5),
    UpTopic("task/confirm", "std_msgs/msg/Bool", ("task/confirm",), clone=False),
    UpTopic("detected_dock_pose", "geometry_msgs/msg/PoseStamped", ("detected_dock_pose",)),
    UpTopic("lift_state", "std_msgs/msg/Bool", ("lift_state",)),
    UpTopic("local_costmap/footprint", "geometry_msgs/msg/Polygon", ("local_costmap/footprint",), reliable=True),
)
"""Topics of the robot, besides ``tf`` and ``tf_static``."""


RELIABLE: Final = Qos()


@dataclass(frozen=True, slots=True)
class DownTopic:
    """Topic that the clone publishes.

    Parameters
    ----------
    cloud, cloud_type : str
        Name and type in the cloud.
    name, type : str
        Name in the robot's namespace, and type there, spelled as in ROS 2.
    qos : Qos
        Quality of service.
    always : bool
        Whether it is carried even if nobody in ROS subscribes to it.
    """

    cloud: str
    cloud_type: str
    name: str
    type: str
    qos: Qos = RELIABLE
    always: bool = False


_GRID = "nav_msgs/msg/OccupancyGrid"
_POLYGON = "geometry_msgs/msg/PolygonStamped"
_OCTOMAP = "octomap_msgs/msg/Octomap"
MAP: Final = DownTopic("map", _GRID, "map", _GRID, LATCHED, always=True)
MAP_UPDATES: Final = DownTopic(
    "map_updates", "map_msgs/msg/OccupancyGridUpdate", "map_updates", "map_msgs/msg/OccupancyGridUpdate"
)
MAP_METADATA: Final = DownTopic(
    "map_metadata", "nav_msgs/msg/MapMetaData", "map_metadata", "nav_msgs/msg/MapMetaData", LATCHED
)
"""Size and origin of the map, which ROS 1 has on a separate topic: published with each map that the cloud sends."""
PARTICLES: Final = DownTopic(
    "particlecloud", "geometry_msgs/msg/PoseArray", "particle_cloud", "nav2_msgs/msg/ParticleCloud", SENSOR
)
_POSE = "geometry_msgs/msg/PoseWithCovarianceStamped"
_FOOTPRINT = "local_costmap/published_footprint"
DOWN: Final = (
    MAP,
    MAP_UPDATES,
    PARTICLES,
    DownTopic("plan", "nav_msgs/msg/Path", "plan", "nav_msgs/msg/Path"),
    DownTopic("local_plan", "nav_msgs/msg/Path", "local_plan", "nav_msgs/msg/Path"),
    DownTopic("amcl_pose", _POSE, "amcl_pose", _POSE, LATCHED),
    DownTopic("global_costmap/costmap", _GRID, "global_costmap/costmap", _GRID, LATCHED),
    DownTopic("local_costmap/costmap", _GRID, "local_costmap/costmap", _GRID, LATCHED),
    DownTopic(_FOOTPRINT, _POLYGON, _FOOTPRINT, _POLYGON),
    DownTopic("lift", "std_msgs/msg/Bool", "lift", "std_msgs/msg/Bool", LATCHED),
    DownTopic("octomap_binary", _OCTOMAP, "octomap_binary", _OCTOMAP, LATCHED),
    DownTopic("octomap_full", _OCTOMAP, "octomap_full", _OCTOMAP, LATCHED),
    DownTopic("projected_map", _GRID, "projected_map", _GRID, LATCHED),
)
"""Topics of the clone, besides ``cmd_vel`` and ``tf``."""


@dataclass(frozen=True, slots=True)
class BridgedService:
    """Service that the clone answers: its name and type at the robot, and those in the cloud."""

    name: str
    type: str
    cloud: str
    cloud_type: str


_CLEAR = "nav2_msgs/srv/ClearEntireCostmap"
_EMPTY = "std_srvs/srv/Empty"
SERVICES: Final = tuple(
    BridgedService(name, kind, cloud, kind)
    for name, kind, cloud in (
        ("global_costmap/clear_entirely_global_costmap", _CLEAR, "global_costmap/clear_entirely_global_costmap"),
        ("local_costmap/clear_entirely_local_costmap", _CLEAR, "local_costmap/clear_entirely_local_costmap"),
        ("is_path_valid", "nav2_msgs/srv/IsPathValid", "is_path_valid"),
        ("reinitialize_global_localization", _EMPTY, "global_localization"),
        ("request_nomotion_update", _EMPTY, "request_nomotion_update"),
        ("map_server/map", "nav_msgs/srv/GetMap", "static_map"),
    )
)

ACTIONS: Final = {
    "navigate_to_pose": "nav2_msgs/action/NavigateToPose",
    "follow_waypoints": "nav2_msgs/action/FollowWaypoints",
    "compute_path_to_pose": "nav2_msgs/action/ComputePathToPose",
    "navigate_through_poses": "nav2_msgs/action/NavigateThroughPoses",
    "compute_path_through_poses": "nav2_msgs/action/ComputePathThroughPoses",
    "follow_path": "nav2_msgs/action/FollowPath",
    "compute_route": "nav2_msgs/action/ComputeRoute",
    "compute_and_track_route": "nav2_msgs/action/ComputeAndTrackRoute",
    "follow_object": "nav2_msgs/action/FollowObject",
    "spin": "nav2_msgs/action/Spin",
    "backup": "nav2_msgs/action/BackUp",
    "drive_on_heading": "nav2_msgs/action/DriveOnHeading",
    "wait": "nav2_msgs/action/Wait",
    "dock_robot": "nav2_msgs/action/DockRobot",
    "undock_robot": "nav2_msgs/action/UndockRobot",
}
"""Types of the actions of Nav2 that the clone executes, by their names, which the cloud uses too."""

OTHER_PACKAGES: Final = {
    "nav2_msgs/action/DockRobot": "opennav_docking_msgs/action/DockRobot",
    "nav2_msgs/action/UndockRobot": "opennav_docking_msgs/action/UndockRobot",
}
"""Types of actions in releases in which another package than ``nav2_msgs`` has them, by those of later releases."""


@dataclass(frozen=True, slots=True)
class Tables:
    """Names by which the nodes of a robot know what the bridge carries.

    Parameters
    ----------
    up, down : tuple
        Topics of the robot, besides ``tf`` and ``tf_static``, and of the clone, besides ``cmd_vel`` and ``tf``.
    services : tuple of BridgedService
        Services that the clone answers.
    actions : mapping of str to str
        Types of the actions that the clone executes, by their names.
    """

    up: tuple[UpTopic, ...]
    down: tuple[DownTopic, ...]
    services: tuple[BridgedService, ...]
    actions: Mapping[str, str]


ROS_2: Final = Tables(UP, DOWN, SERVICES, ACTIONS)
