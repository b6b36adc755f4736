"""ROS messages as typed structs, found by their ROS names.

Each ROS package is one module. ``decode`` and ``encode`` use the JSON of rosbridge, where NaN and infinity are null.
"""

from ppaas.messages import (
    actionlib_msgs,
    explore_msgs,
    geometry_msgs,
    move_base_msgs,
    nav2_msgs,
    nav_msgs,
    octomap_msgs,
    people_coordination,
    people_msgs,
    ppaas_msgs,
    sensor_msgs,
    slam_toolbox,
    std_srvs,
    tf2_msgs,
    tf2_web_republisher,
    vision_msgs,
)
from ppaas.messages.base import map_msgs, rosapi, std_msgs
from ppaas.messages.base.message import Lazy, Message, ServiceType
from ppaas.messages.codec import decode, encode
from ppaas.messages.registry import message_type, message_types, service_type, type_name

__all__ = [
    "Lazy",
    "Message",
    "ServiceType",
    "actionlib_msgs",
    "decode",
    "encode",
    "explore_msgs",
    "geometry_msgs",
    "map_msgs",
    "message_type",
    "message_types",
    "move_base_msgs",
    "nav2_msgs",
    "nav_msgs",
    "octomap_msgs",
    "people_coordination",
    "people_msgs",
    "ppaas_msgs",
    "rosapi",
    "sensor_msgs",
    "service_type",
    "slam_toolbox",
    "std_msgs",
    "std_srvs",
    "tf2_msgs",
    "tf2_web_republisher",
    "type_name",
    "vision_msgs",
]
