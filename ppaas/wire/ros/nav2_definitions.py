"""Definitions of ``nav2_msgs``, whose actions and services differ between releases, as the text of their files.

Sources: ``nav2_msgs`` of ``ros-navigation/navigation2``, and docs.ros.org, which has the definitions of each release.
"""

from typing import Final

# -- parts of definitions ----------------------------------------------------------------------------------------------

_FEEDBACK_OF_POSE = """
        geometry_msgs/PoseStamped current_pose
        builtin_interfaces/Duration navigation_time
        builtin_interfaces/Duration estimated_time_remaining
        int16 number_of_recoveries
        float32 distance_remaining
"""

_ERROR = "uint16 error_code\nstring error_msg"
_CODED = "uint16 error_code 0\nstring error_msg"
_PATH = "nav_msgs/Path path\nbuiltin_interfaces/Duration planning_time"

_GOAL_OF_PATH = """
        geometry_msgs/PoseStamped goal
        geometry_msgs/PoseStamped start
        string planner_id
        bool use_start
        ---
"""

_GOAL_OF_BEHAVIOR = "geometry_msgs/Point target\nfloat32 speed\nbuiltin_interfaces/Duration time_allowance"
_ELAPSED = "builtin_interfaces/Duration total_elapsed_time"
_CHECKS = "bool disable_collision_checks"

_GOAL_OF_ROUTE = """
        uint16 start_id
        geometry_msgs/PoseStamped start
        uint16 goal_id
        geometry_msgs/PoseStamped goal
        bool use_start
        bool use_poses
        ---
"""

_ROUTE = """
        builtin_interfaces/Duration planning_time
        nav_msgs/Path path
        nav2_msgs/Route route
"""

_FEEDBACK_OF_ROUTE = """
        uint16 last_node_id
        uint16 next_node_id
        uint16 current_edge_id
        nav2_msgs/Route route
        nav_msgs/Path path
        string[] operations_triggered
        bool rerouted
"""


def _behaviors(checks: str, error: str) -> dict[str, str]:
    """Return the actions of Nav2's behaviours, given the last field of their goals and those of their results."""
    driven = f"""
        {_GOAL_OF_BEHAVIOR}
        {checks}
        ---
        {_ELAPSED}
        {error}
        ---
        float32 distance_traveled
    """
    return {
        "nav2_msgs/action/Spin": f"""
            float32 target_yaw
            builtin_interfaces/Duration time_allowance
            {checks}
            ---
            {_ELAPSED}
            {error}
            ---
            float32 angular_distance_traveled
        """,
        "nav2_msgs/action/BackUp": driven,
        "nav2_msgs/action/DriveOnHeading": driven,
        "nav2_msgs/action/Wait": f"""
            builtin_interfaces/Duration time
            ---
            {_ELAPSED}
            {error}
            ---
            builtin_interfaces/Duration time_left
        """,
    }


def _through(poses: str, result: str, tracking: str, statuses: str) -> dict[str, str]:
    """Return the action NavigateThroughPoses, given the type of its poses and fields of its result and feedback."""
    text = f"""
        {poses} poses
        string behavior_tree
        ---
        {result}
        {statuses}
        ---
        {_FEEDBACK_OF_POSE}
        {tracking}
        int16 number_of_poses_remaining
        {statuses}
    """
    return {"nav2_msgs/action/NavigateThroughPoses": text}


def _path_through(goals: str, reached: str, error: str) -> dict[str, str]:
    """Return the action ComputePathThroughPoses, given the type of its goals and fields of its result."""
    text = f"""
        {goals} goals
        geometry_msgs/PoseStamped start
        string planner_id
        bool use_start
        ---
        nav_msgs/Path path
        {reached}
        builtin_interfaces/Duration planning_time
        {error}
        ---
    """
    return {"nav2_msgs/action/ComputePathThroughPoses": text}


def _follow_path(ids: str, error: str, feedback: str) -> dict[str, str]:
    """Return the action FollowPath, given the last fields of its goal and result, and its feedback."""
    text = f"""
        nav_msgs/Path path
        string controller_id
        string goal_checker_id
        {ids}
        ---
        std_msgs/Empty result
        {error}
        ---
        {feedback}
    """
    return {"nav2_msgs/action/FollowPath": text}


def _routes(error: str) -> dict[str, str]:
    """Return the actions of Nav2's route server, given the last fields of their results."""
    return {
        "nav2_msgs/action/ComputeRoute": f"{_GOAL_OF_ROUTE}\n{_ROUTE}\n{error}\n---\n",
        "nav2_msgs/action/ComputeAndTrackRoute": f"""
            {_GOAL_OF_ROUTE}
            builtin_interfaces/Duration execution_duration
            {error}
            ---
            {_FEEDBACK_OF_ROUTE}
        """,
    }


_PROGRESS_CHECKER = "string progress_checker_id"
_POSES, _GOALS = "geometry_msgs/PoseStamped[]", "nav_msgs/Goals"
_FOLLOWED = "float32 distance_to_goal\nfloat32 speed"
_TRACKING = "float32 position_tracking_error\nfloat32 heading_tracking_error"
_STATUSES = "nav2_msgs/WaypointStatus[] waypoint_statuses"
_PATH_IS_VALID = "---\nbool is_valid\nint32[] invalid_pose_indices"
_PATH_TO_CHECK = "nav_msgs/Path path\nuint8 max_cost 254\nbool consider_unknown_as_obstacle false\n"

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
    "nav2_msgs/msg/RouteNode": """
        uint16 nodeid
        geometry_msgs/Point position
    """,
    "nav2_msgs/msg/RouteEdge": """
        uint16 edgeid
        geometry_msgs/Point start
        geometry_msgs/Point end
    """,
    "nav2_msgs/msg/Route": """
        std_msgs/Header header
        float32 route_cost
        nav2_msgs/RouteNode[] nodes
        nav2_msgs/RouteEdge[] edges
    """,
}
"""Messages that are the same in all releases."""

HUMBLE: Final = {
    **_behaviors("", ""),
    **_through(_POSES, "std_msgs/Empty result", "", ""),
    **_path_through(_POSES, "", ""),
    **_follow_path("", "", _FOLLOWED),
    **_routes(""),
    "nav2_msgs/srv/IsPathValid": f"nav_msgs/Path path\n{_PATH_IS_VALID}",
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
    **_behaviors("", _ERROR),
    **_through(_POSES, _ERROR, "", ""),
    **_path_through(_POSES, "", _ERROR),
    **_follow_path(_PROGRESS_CHECKER, _ERROR, _FOLLOWED),
    **_routes("uint16 error_code 0"),
    "nav2_msgs/srv/IsPathValid": f"nav_msgs/Path path\n{_PATH_IS_VALID}",
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
    **_behaviors(_CHECKS, _ERROR),
    **_through(_GOALS, _ERROR, "", _STATUSES),
    **_path_through(_GOALS, "", _ERROR),
    **_follow_path(_PROGRESS_CHECKER, _ERROR, _FOLLOWED),
    **_routes(_CODED),
    "nav2_msgs/srv/IsPathValid": _PATH_TO_CHECK + _PATH_IS_VALID,
    "nav_msgs/msg/Goals": """
        std_msgs/Header header
        geometry_msgs/PoseStamped[] goals
    """,
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
    **_through(_GOALS, _ERROR, _TRACKING, _STATUSES),
    **_path_through(_GOALS, "int16 last_reached_index", _ERROR),
    **_follow_path(
        f"{_PROGRESS_CHECKER}\n        string path_handler_id", _ERROR, "nav2_msgs/TrackingFeedback tracking_feedback"
    ),
    "nav2_msgs/msg/TrackingFeedback": """
        std_msgs/Header header
        float32 position_tracking_error
        float32 heading_tracking_error
        uint32 current_path_index
        geometry_msgs/PoseStamped robot_pose
        float32 distance_to_goal
        float32 speed
        float32 remaining_path_length
    """,
    "nav2_msgs/srv/IsPathValid": f"""
        {_PATH_TO_CHECK}
        string layer_name ""
        string footprint ""
        bool stop_at_first_collision true
        float64 max_lookahead_distance -1.0
        ---
        bool success
        bool is_valid
        int32[] invalid_pose_indices
    """,
    "nav2_msgs/action/FollowObject": f"""
        string pose_topic
        string tracked_frame
        builtin_interfaces/Duration max_duration
        ---
        {_ELAPSED}
        uint16 error_code 0
        uint16 num_retries 0
        string error_msg
        ---
        uint16 state
        builtin_interfaces/Duration following_time
        uint16 num_retries 0
    """,
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
