"""Definitions of messages, services and actions that ``rosbags`` lacks, as the text of their files, by release."""

from collections.abc import Mapping

from ppaas.wire.ros.definitions import nav2, ros1, ros2

DEFINITIONS: Mapping[str, Mapping[str, str]] = {
    "noetic": ros1.NOETIC,
    "humble": ros2.COMMON | nav2.COMMON | nav2.HUMBLE,
    "jazzy": ros2.COMMON | nav2.COMMON | nav2.SINCE_JAZZY | nav2.JAZZY,
    "kilted": ros2.COMMON | nav2.COMMON | nav2.SINCE_JAZZY | nav2.KILTED,
    "lyrical": ros2.COMMON | nav2.COMMON | nav2.KILTED | nav2.LYRICAL,
}
"""Text of each definition by its full name, such as ``nav2_msgs/action/Wait``, for each release."""
