"""Definitions of messages, services and actions that ``rosbags`` lacks, as the text of their files, by release.

Sources: ``ros2/common_interfaces``, ``ros2/rcl_interfaces``, ``ros-planning/navigation_msgs``, ``ros/geometry2``,
``ros/geometry``, ``ros/ros_comm_msgs``, ``wg-perception/people``, ``ros-perception/vision_msgs``,
``OctoMap/octomap_msgs``, ``nav2_msgs`` of ``ros-navigation/navigation2``, and docs.ros.org, which has the definitions
of each release.
"""

from collections.abc import Mapping
from typing import Final

from ppaas.wire.ros.rmf_definitions import RMF

# -- definitions that are the same in all releases of ROS 2 -----------------------------------------------------------

COMMON: Final = {
    "action_msgs/srv/CancelGoal": """
        action_msgs/GoalInfo goal_info
        ---
        int8 ERROR_NONE=0
        int8 ERROR_REJECTED=1
        int8 ERROR_UNKNOWN_GOAL_ID=2
        int8 ERROR_GOAL_TERMINATED=3
        int8 return_code
        action_msgs/GoalInfo[] goals_canceling
    """,
    "map_msgs/msg/OccupancyGridUpdate": """
        std_msgs/Header header
        int32 x
        int32 y
        uint32 width
        uint32 height
        int8[] data
    """,
    "nav_msgs/srv/GetMap": """
        ---
        nav_msgs/OccupancyGrid map
    """,
    "nav_msgs/srv/GetPlan": """
        geometry_msgs/PoseStamped start
        geometry_msgs/PoseStamped goal
        float32 tolerance
        ---
        nav_msgs/Path plan
    """,
    "octomap_msgs/msg/Octomap": """
        std_msgs/Header header
        bool binary
        string id
        float64 resolution
        int8[] data
    """,
    "people_msgs/msg/Person": """
        string name
        geometry_msgs/Point position
        geometry_msgs/Point velocity
        float64 reliability
        string[] tagnames
        string[] tags
    """,
    "people_msgs/msg/People": """
        std_msgs/Header header
        people_msgs/Person[] people
    """,
    "std_srvs/srv/Empty": "---",
    "std_srvs/srv/SetBool": """
        bool data
        ---
        bool success
        string message
    """,
    "std_srvs/srv/Trigger": """
        ---
        bool success
        string message
    """,
    "vision_msgs/msg/ObjectHypothesis": """
        string class_id
        float64 score
    """,
    "vision_msgs/msg/ObjectHypothesisWithPose": """
        vision_msgs/ObjectHypothesis hypothesis
        geometry_msgs/PoseWithCovariance pose
    """,
    "vision_msgs/msg/BoundingBox3D": """
        geometry_msgs/Pose center
        geometry_msgs/Vector3 size
    """,
    "vision_msgs/msg/Detection3D": """
        std_msgs/Header header
        vision_msgs/ObjectHypothesisWithPose[] results
        vision_msgs/BoundingBox3D bbox
        string id
    """,
    "vision_msgs/msg/Detection3DArray": """
        std_msgs/Header header
        vision_msgs/Detection3D[] detections
    """,
}

# -- ``nav2_msgs``, whose results differ between releases --------------------------------------------------------------

_FEEDBACK_OF_POSE = """
        geometry_msgs/PoseStamped current_pose
        builtin_interfaces/Duration navigation_time
        builtin_interfaces/Duration estimated_time_remaining
        int16 number_of_recoveries
        float32 distance_remaining
"""

_ERROR = """
        uint16 error_code
        string error_msg
"""

_PATH = """
        nav_msgs/Path path
        builtin_interfaces/Duration planning_time
"""

_GOAL_OF_PATH = """
        geometry_msgs/PoseStamped goal
        geometry_msgs/PoseStamped start
        string planner_id
        bool use_start
        ---
"""

_GOAL_OF_WAYPOINTS = """
        uint32 number_of_loops
        uint32 goal_index 0
        geometry_msgs/PoseStamped[] poses
        ---
"""

NAV2_COMMON: Final = {
    "nav2_msgs/msg/Particle": """
        geometry_msgs/Pose pose
        float64 weight
    """,
    "nav2_msgs/msg/ParticleCloud": """
        std_msgs/Header header
        nav2_msgs/Particle[] particles
    """,
    "nav2_msgs/msg/SpeedLimit": """
        std_msgs/Header header
        bool percentage
        float64 speed_limit
    """,
}
"""Messages that are the same in all releases."""

HUMBLE: Final = {
    "nav2_msgs/action/NavigateToPose": f"""
        geometry_msgs/PoseStamped pose
        string behavior_tree
        ---
        std_msgs/Empty result
        ---
        {_FEEDBACK_OF_POSE}
    """,
    "nav2_msgs/action/FollowWaypoints": """
        geometry_msgs/PoseStamped[] poses
        ---
        int32[] missed_waypoints
        ---
        uint32 current_waypoint
    """,
    "nav2_msgs/action/ComputePathToPose": f"""
        {_GOAL_OF_PATH}
        {_PATH}
        ---
    """,
    "nav2_msgs/srv/ClearEntireCostmap": """
        std_msgs/Empty request
        ---
        std_msgs/Empty response
    """,
}

SINCE_JAZZY: Final = {
    "nav2_msgs/action/NavigateToPose": f"""
        geometry_msgs/PoseStamped pose
        string behavior_tree
        ---
        {_ERROR}
        ---
        {_FEEDBACK_OF_POSE}
    """,
    "nav2_msgs/action/ComputePathToPose": f"""
        {_GOAL_OF_PATH}
        {_PATH}
        {_ERROR}
        ---
    """,
    "nav2_msgs/srv/ClearEntireCostmap": """
        std_msgs/Empty request
        ---
        std_msgs/Empty response
    """,
}
"""Definitions of Jazzy and Kilted."""

JAZZY: Final = {
    "nav2_msgs/msg/MissedWaypoint": """
        uint32 index
        geometry_msgs/PoseStamped goal
        uint16 error_code
    """,
    "nav2_msgs/action/FollowWaypoints": f"""
        {_GOAL_OF_WAYPOINTS}
        nav2_msgs/MissedWaypoint[] missed_waypoints
        {_ERROR}
        ---
        uint32 current_waypoint
    """,
}

KILTED: Final = {
    "nav2_msgs/msg/WaypointStatus": f"""
        uint8 PENDING=0
        uint8 COMPLETED=1
        uint8 SKIPPED=2
        uint8 FAILED=3
        uint8 waypoint_status
        uint32 waypoint_index
        geometry_msgs/PoseStamped waypoint_pose
        {_ERROR}
    """,
    "nav2_msgs/action/FollowWaypoints": f"""
        {_GOAL_OF_WAYPOINTS}
        nav2_msgs/WaypointStatus[] missed_waypoints
        {_ERROR}
        ---
        uint32 current_waypoint
    """,
}

LYRICAL: Final = {
    "nav2_msgs/action/NavigateToPose": f"""
        geometry_msgs/PoseStamped pose
        string behavior_tree
        ---
        {_ERROR}
        ---
        {_FEEDBACK_OF_POSE}
        float32 position_tracking_error
        float32 heading_tracking_error
    """,
    "nav2_msgs/action/ComputePathToPose": f"""
        geometry_msgs/PoseStamped goal
        geometry_msgs/PoseStamped start
        geometry_msgs/PoseStamped[] viapoints
        string planner_id
        bool use_start
        ---
        {_PATH}
        {_ERROR}
        ---
    """,
    "nav2_msgs/srv/ClearEntireCostmap": """
        string[] plugins
        ---
        bool success
    """,
}

# -- ROS 1 Noetic ------------------------------------------------------------------------------------------------------

_ACTION_PART = """
        std_msgs/Header header
        {status}
        move_base_msgs/MoveBase{part} {field}
"""

_SAME_AS_IN_ROS_2 = (
    "map_msgs/msg/OccupancyGridUpdate",
    "nav_msgs/srv/GetMap",
    "nav_msgs/srv/GetPlan",
    "octomap_msgs/msg/Octomap",
    "people_msgs/msg/Person",
    "people_msgs/msg/People",
    "std_srvs/srv/Empty",
    "std_srvs/srv/SetBool",
    "std_srvs/srv/Trigger",
)

NOETIC: Final = {name: COMMON[name] for name in _SAME_AS_IN_ROS_2} | {
    "move_base_msgs/msg/MoveBaseGoal": "geometry_msgs/PoseStamped target_pose",
    "move_base_msgs/msg/MoveBaseResult": "",
    "move_base_msgs/msg/MoveBaseFeedback": "geometry_msgs/PoseStamped base_position",
    "move_base_msgs/msg/MoveBaseActionGoal": _ACTION_PART.format(
        status="actionlib_msgs/GoalID goal_id", part="Goal", field="goal"
    ),
    "move_base_msgs/msg/MoveBaseActionResult": _ACTION_PART.format(
        status="actionlib_msgs/GoalStatus status", part="Result", field="result"
    ),
    "move_base_msgs/msg/MoveBaseActionFeedback": _ACTION_PART.format(
        status="actionlib_msgs/GoalStatus status", part="Feedback", field="feedback"
    ),
    "move_base_msgs/msg/MoveBaseAction": """
        move_base_msgs/MoveBaseActionGoal action_goal
        move_base_msgs/MoveBaseActionResult action_result
        move_base_msgs/MoveBaseActionFeedback action_feedback
    """,
    "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "tf/msg/tfMessage": "geometry_msgs/TransformStamped[] transforms",
}

DEFINITIONS: Mapping[str, Mapping[str, str]] = {
    "noetic": NOETIC,
    "humble": COMMON | RMF | NAV2_COMMON | HUMBLE,
    "jazzy": COMMON | RMF | NAV2_COMMON | SINCE_JAZZY | JAZZY,
    "kilted": COMMON | RMF | NAV2_COMMON | SINCE_JAZZY | KILTED,
    "lyrical": COMMON | RMF | NAV2_COMMON | KILTED | LYRICAL,
}
"""Text of each definition by its full name, such as ``nav2_msgs/action/Wait``, for each release."""
