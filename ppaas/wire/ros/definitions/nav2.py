"""Definitions of ``nav2_msgs``, whose results differ between releases.

Source: ``nav2_msgs`` of ``ros-navigation/navigation2``, and docs.ros.org, which has the definitions of each release.
"""

from typing import Final

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

COMMON: Final = {
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
