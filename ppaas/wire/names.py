"""Validation of ROS names that clients send: topics, services, nodes and types."""

import re
from collections.abc import Callable

from ppaas.errors import MalformedMessage, UnknownType
from ppaas.messages.time_spelling import camera_to_ros2, to_ros2

_NAME = re.compile(r"/?[A-Za-z~][\w~]*(/[\w~]+)*", re.ASCII)
_TYPE = re.compile(r"([A-Za-z]\w*)/(?:(msg|srv|action)/)?([A-Za-z]\w*)", re.ASCII)
MAX_NAME = 255


def normalise(name: str) -> str:
    """Return a graph name without its leading slash, the form used inside the cloud.

    Raises
    ------
    MalformedMessage
        It is not a ROS graph name, or longer than ``MAX_NAME`` characters.
    """
    if len(name) > MAX_NAME or not _NAME.fullmatch(name):
        raise MalformedMessage(f"not a ROS graph name: {name[:64]!r}")
    return name.removeprefix("/")


def callee(name: str) -> str:
    """Return the name of a service or an action in the form used inside the cloud.

    An id that old clients append after ``#`` is cut off, as in rosbridge_suite.

    Raises
    ------
    MalformedMessage
        It is not a ROS graph name.
    """
    return normalise(name.partition("#")[0])


def ros1_type(name: str) -> str:
    """Return a type name as spelled in ROS 1, ``package/Name``, whether or not the type is known.

    Raises
    ------
    UnknownType
        It is not a ROS type name.
    """
    match = _TYPE.fullmatch(name) if len(name) <= MAX_NAME else None
    if match is None:
        raise UnknownType(f"not a ROS type name: {name[:64]!r}; write it as package/Name or package/msg/Name")
    return f"{match[1]}/{match[3]}"


def ros2_spelling(name: str | None) -> Callable[[bytes], bytes] | None:
    """Return the function that spells messages as in ROS 2, for clients that name their type so; None for others.

    Parameters
    ----------
    name : str, optional
        Name of the type, as the client spelled it.
    """
    if name is None or not is_ros2_type(name):
        return None
    return camera_to_ros2 if ros1_type(name) == "sensor_msgs/CameraInfo" else to_ros2


def is_ros2_type(name: str | None) -> bool:
    """Return whether a type name is spelled as in ROS 2; such a client also expects ROS 2's spelling of times."""
    match = _TYPE.fullmatch(name) if name is not None else None
    return match is not None and match[2] is not None
