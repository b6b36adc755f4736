"""Conversion of times between the keys of ROS 1 (``secs``, ``nsecs``) and ROS 2 (``sec``, ``nanosec``).

The matrices of a ``CameraInfo``, which have small letters in ROS 2, are converted too.

Inside the cloud, messages use the keys of ROS 1. The JSON text is converted without parsing: a quoted word followed by
a colon can only be a key, since quotes within a string have a backslash before them. The backslash also excludes a
longer key whose last characters look like one of these keys.
"""

import re
from typing import Final

_KEY_OF_ROS1: Final = re.compile(rb'"(n?)secs"(?<!\\"secs")(?<!\\"nsecs")(?=\s*:)')
_KEY_OF_ROS2: Final = re.compile(rb'"(nano)?sec"(?<!\\"sec")(?<!\\"nanosec")(?=\s*:)')

_MATRIX_OF_ROS1: Final = re.compile(rb'(?<!\\)"([DKRP])"(?=\s*:)')


def to_ros2(payload: bytes) -> bytes:
    """Return a JSON message with the time keys of ROS 1 replaced by the keys of ROS 2."""
    return _KEY_OF_ROS1.sub(lambda key: b'"nanosec"' if key[1] else b'"sec"', payload)


def camera_to_ros2(payload: bytes) -> bytes:
    """Return a ``CameraInfo`` as JSON with the keys of ROS 2."""
    return _MATRIX_OF_ROS1.sub(lambda key: b'"%b"' % key[1].lower(), to_ros2(payload))


def to_ros1(payload: bytes) -> bytes:
    """Return a JSON message with the time keys of ROS 2 replaced by the keys of ROS 1."""
    return _KEY_OF_ROS2.sub(lambda key: b'"nsecs"' if key[1] else b'"secs"', payload)
