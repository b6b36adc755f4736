"""Definitions of ROS 1 Noetic.

Sources: ``ros-planning/navigation_msgs``, ``ros/geometry2``, ``ros/geometry``, ``ros/ros_comm_msgs``,
``wg-perception/people``, ``OctoMap/octomap_msgs``.
"""

from typing import Final

from ppaas.wire.ros.definitions.ros2 import COMMON

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
