"""Definitions of ``rmf_fleet_msgs``, ``rmf_lift_msgs`` and ``rmf_door_msgs``, as the text of their files.

Open-RMF and drivers of fleets, lifts and doors speak by them.

Source: ``open-rmf/rmf_internal_msgs`` since version 3, which is the same in all releases of ROS 2.
"""

from typing import Final

FLEET_STATE: Final = "rmf_fleet_msgs/msg/FleetState"
PATH_REQUEST: Final = "rmf_fleet_msgs/msg/PathRequest"
MODE_REQUEST: Final = "rmf_fleet_msgs/msg/ModeRequest"
DESTINATION_REQUEST: Final = "rmf_fleet_msgs/msg/DestinationRequest"
LIFT_STATE: Final = "rmf_lift_msgs/msg/LiftState"
LIFT_REQUEST: Final = "rmf_lift_msgs/msg/LiftRequest"
DOOR_STATE: Final = "rmf_door_msgs/msg/DoorState"
DOOR_REQUEST: Final = "rmf_door_msgs/msg/DoorRequest"

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
    LIFT_STATE: """
        builtin_interfaces/Time lift_time
        string lift_name
        string[] available_floors
        string current_floor
        string destination_floor
        uint8 door_state
        uint8 DOOR_CLOSED=0
        uint8 DOOR_MOVING=1
        uint8 DOOR_OPEN=2
        uint8 motion_state
        uint8 MOTION_STOPPED=0
        uint8 MOTION_UP=1
        uint8 MOTION_DOWN=2
        uint8 MOTION_UNKNOWN=3
        uint8[] available_modes
        uint8 current_mode
        uint8 MODE_UNKNOWN=0
        uint8 MODE_HUMAN=1
        uint8 MODE_AGV=2
        uint8 MODE_FIRE=3
        uint8 MODE_OFFLINE=4
        uint8 MODE_EMERGENCY=5
        string session_id
    """,
    LIFT_REQUEST: """
        string lift_name
        builtin_interfaces/Time request_time
        string session_id
        uint8 request_type
        uint8 REQUEST_END_SESSION=0
        uint8 REQUEST_AGV_MODE=1
        uint8 REQUEST_HUMAN_MODE=2
        string destination_floor
        uint8 door_state
        uint8 DOOR_CLOSED=0
        uint8 DOOR_OPEN=2
    """,
    "rmf_door_msgs/msg/DoorMode": """
        uint32 value
        uint32 MODE_CLOSED=0
        uint32 MODE_MOVING=1
        uint32 MODE_OPEN=2
        uint32 MODE_OFFLINE=3
        uint32 MODE_UNKNOWN=4
    """,
    DOOR_STATE: """
        builtin_interfaces/Time door_time
        string door_name
        rmf_door_msgs/DoorMode current_mode
    """,
    DOOR_REQUEST: """
        builtin_interfaces/Time request_time
        string requester_id
        string door_name
        rmf_door_msgs/DoorMode requested_mode
    """,
}
