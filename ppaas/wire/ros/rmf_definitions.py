"""Definitions of ``rmf_fleet_msgs``, by which Open-RMF and drivers of fleets speak, as the text of their files.

Source: ``open-rmf/rmf_internal_msgs`` since version 3, which is the same in all releases of ROS 2.
"""

from typing import Final

FLEET_STATE: Final = "rmf_fleet_msgs/msg/FleetState"
PATH_REQUEST: Final = "rmf_fleet_msgs/msg/PathRequest"
MODE_REQUEST: Final = "rmf_fleet_msgs/msg/ModeRequest"
DESTINATION_REQUEST: Final = "rmf_fleet_msgs/msg/DestinationRequest"

RMF: Final = {
    "rmf_fleet_msgs/msg/Location": """
        builtin_interfaces/Time t
        float32 x
        float32 y
        float32 yaw
        bool obey_approach_speed_limit
        float32 approach_speed_limit
        string level_name
        uint64 index
    """,
    "rmf_fleet_msgs/msg/RobotMode": """
        uint32 mode
        uint32 MODE_IDLE=0
        uint32 MODE_CHARGING=1
        uint32 MODE_MOVING=2
        uint32 MODE_PAUSED=3
        uint32 MODE_WAITING=4
        uint32 MODE_EMERGENCY=5
        uint32 MODE_GOING_HOME=6
        uint32 MODE_DOCKING=7
        uint32 MODE_ADAPTER_ERROR=8
        uint32 MODE_CLEANING=9
        uint32 MODE_PERFORMING_ACTION=10
        uint32 MODE_ACTION_COMPLETED=11
        uint64 mode_request_id
        string performing_action
    """,
    "rmf_fleet_msgs/msg/ModeParameter": """
        string name
        string value
    """,
    "rmf_fleet_msgs/msg/RobotState": """
        string name
        string model
        string task_id
        uint64 seq
        rmf_fleet_msgs/RobotMode mode
        float32 battery_percent
        rmf_fleet_msgs/Location location
        rmf_fleet_msgs/Location[] path
    """,
    FLEET_STATE: """
        string name
        rmf_fleet_msgs/RobotState[] robots
    """,
    PATH_REQUEST: """
        string fleet_name
        string robot_name
        rmf_fleet_msgs/Location[] path
        string task_id
    """,
    MODE_REQUEST: """
        string fleet_name
        string robot_name
        rmf_fleet_msgs/RobotMode mode
        string task_id
        rmf_fleet_msgs/ModeParameter[] parameters
    """,
    DESTINATION_REQUEST: """
        string fleet_name
        string robot_name
        rmf_fleet_msgs/Location destination
        string task_id
    """,
}
