"""Stamps and durations in the spellings of ROS 1 (``secs``, ``nsecs``) and ROS 2 (``sec``, ``nanosec``).

Messages have the spelling of ROS 1 inside. They are respelled as text, without being parsed: only a key may be a
quoted word with a colon behind it, since within a string every quote has a backslash before it. The same backslash
tells a key that merely ends in the word.
"""

import re
from typing import Final

_KEY_OF_ROS1: Final = re.compile(rb'"(n?)secs"(?<!\\"secs")(?<!\\"nsecs")(?=\s*:)')
_KEY_OF_ROS2: Final = re.compile(rb'"(nano)?sec"(?<!\\"sec")(?<!\\"nanosec")(?=\s*:)')


def to_ros2(payload: bytes) -> bytes:
    """Return a message of JSON with its times as ROS 2 spells them."""
    return _KEY_OF_ROS1.sub(lambda key: b'"nanosec"' if key[1] else b'"sec"', payload)


def to_ros1(payload: bytes) -> bytes:
    """Return a message of JSON with its times as ROS 1 spells them."""
    return _KEY_OF_ROS2.sub(lambda key: b'"nsecs"' if key[1] else b'"secs"', payload)
