"""Messages of ROS as bytes: CDR of ROS 2, the serialization of ROS 1, hashes of types, and the JSON of rosbridge.

``ros_types("jazzy")`` gives the types of a release. A message is a `dict` here, as in rosbridge's JSON; ``encode`` and
``decode`` translate it to and from the bytes that robots send, ``encode_json`` and ``decode_json`` do so for JSON text.
The library ``rosbags`` does the coding (ADR 0043); it is part of the extras ``ros2`` and ``bags``.
"""

from ppaas.wire.ros.types import RosTypes, ros_types

__all__ = ["RosTypes", "ros_types"]
