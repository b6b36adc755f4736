"""Definitions of ROS 2 that are the same in all its releases.

Sources: ``ros2/common_interfaces``, ``ros2/rcl_interfaces``, ``ros-planning/navigation_msgs``,
``wg-perception/people``, ``ros-perception/vision_msgs``, ``OctoMap/octomap_msgs``.
"""

from typing import Final

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
