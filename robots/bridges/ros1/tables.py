"""Names by which navigation of ROS 1 knows what the bridge carries.

Source: http://wiki.ros.org/move_base, http://wiki.ros.org/amcl, http://wiki.ros.org/map_server.
"""

from typing import Final

from ppaas.wire.ros.graph import LATCHED
from robots.bridges.core.tables import MAP, MAP_METADATA, MAP_UPDATES, RELIABLE, UP, DownTopic, Service, Tables

MOVE_BASE: Final = "move_base"

_ROS_2_ONLY = {"goal_pose", "speed_limit", "detections"}
_GRID, _PATH, _POSE = "nav_msgs/msg/OccupancyGrid", "nav_msgs/msg/Path", "geometry_msgs/msg/PoseWithCovarianceStamped"
_EMPTY = "std_srvs/srv/Empty"


def _down(name: str, kind: str, cloud: str = "", *, latched: bool = False) -> DownTopic:
    return DownTopic(cloud or name, kind, name, kind, LATCHED if latched else RELIABLE)


ROS_1: Final = Tables(
    # Goals of `move_base_simple/goal` are taken by the action, as Move Base of ROS 1 does.
    up=tuple(topic for topic in UP if topic.cloud not in _ROS_2_ONLY),
    down=(
        MAP,
        MAP_METADATA,
        MAP_UPDATES,
        _down(f"{MOVE_BASE}/NavfnROS/plan", _PATH, "plan"),
        _down(f"{MOVE_BASE}/DWAPlannerROS/local_plan", _PATH, "local_plan"),
        _down("amcl_pose", _POSE, latched=True),
        _down("particlecloud", "geometry_msgs/msg/PoseArray"),
        _down(f"{MOVE_BASE}/current_goal", "geometry_msgs/msg/PoseStamped"),
        _down(f"{MOVE_BASE}/global_costmap/costmap", _GRID, latched=True),
        _down(f"{MOVE_BASE}/local_costmap/costmap", _GRID, latched=True),
        _down(f"{MOVE_BASE}/local_costmap/footprint", "geometry_msgs/msg/PolygonStamped", latched=True),
        _down("octomap_binary", "octomap_msgs/msg/Octomap", latched=True),
        _down("octomap_full", "octomap_msgs/msg/Octomap", latched=True),
        _down("projected_map", _GRID, latched=True),
    ),
    services=tuple(
        Service(name, kind, name, kind)
        for name, kind in (
            ("static_map", "nav_msgs/srv/GetMap"),
            ("global_localization", _EMPTY),
            ("request_nomotion_update", _EMPTY),
            (f"{MOVE_BASE}/clear_costmaps", _EMPTY),
            (f"{MOVE_BASE}/make_plan", "nav_msgs/srv/GetPlan"),
        )
    ),
    actions={MOVE_BASE: "move_base_msgs/msg/MoveBaseAction"},
)
