"""Definitions of messages, services and actions that ``rosbags`` lacks, as the text of their files, by release.

Sources: ``ros2/common_interfaces``, ``ros2/rcl_interfaces``, ``ros-planning/navigation_msgs``, ``ros/geometry2``,
``ros/geometry``, ``ros/ros_comm_msgs``, ``wg-perception/people``, ``ros-perception/vision_msgs``,
``OctoMap/octomap_msgs``, and docs.ros.org, which has the definitions of each release.
"""

from collections.abc import Mapping
from typing import Final

from ppaas.wire.ros import docking_definitions as docking
from ppaas.wire.ros import nav2_definitions as nav2
from ppaas.wire.ros.rmf_definitions import RMF
from ppaas.wire.ros.rmf_workcells import WORKCELLS

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
    "humble": COMMON | RMF | WORKCELLS | nav2.COMMON | nav2.HUMBLE | docking.HUMBLE,
    "jazzy": COMMON | RMF | WORKCELLS | nav2.COMMON | nav2.SINCE_JAZZY | nav2.JAZZY | docking.SINCE_JAZZY,
    "kilted": COMMON | RMF | WORKCELLS | nav2.COMMON | nav2.SINCE_JAZZY | nav2.KILTED | docking.SINCE_JAZZY,
    "lyrical": COMMON | RMF | WORKCELLS | nav2.COMMON | nav2.KILTED | nav2.LYRICAL | docking.SINCE_JAZZY,
}
"""Text of each definition by its full name, such as ``nav2_msgs/action/Wait``, for each release."""
