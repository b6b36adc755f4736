"""Names of topics, services, nodes and types, as they arrive from clients."""

import re

from ppaas.errors import MalformedMessage, UnknownType

_NAME = re.compile(r"/?[A-Za-z~][\w~]*(/[\w~]+)*", re.ASCII)
_TYPE = re.compile(r"([A-Za-z]\w*)/(?:(msg|srv|action)/)?([A-Za-z]\w*)", re.ASCII)
MAX_NAME = 255


def normalise(name: str) -> str:
    """Return a graph name without its leading slash: the form used inside.

    Raises
    ------
    MalformedMessage
        Not a ROS graph name, or longer than 255 characters.
    """
    if len(name) > MAX_NAME or not _NAME.fullmatch(name):
        raise MalformedMessage(f"not a ROS graph name: {name[:64]!r}")
    return name.removeprefix("/")


def ros1_type(name: str) -> str:
    """Return the name of a type as ROS 1 spells it, ``package/Name``, whether it is known or not.

    Raises
    ------
    UnknownType
        It cannot be the name of a ROS type.
    """
    match = _TYPE.fullmatch(name) if len(name) <= MAX_NAME else None
    if match is None:
        raise UnknownType(f"not a ROS type: {name[:64]!r}; write it as package/Name or package/msg/Name")
    return f"{match[1]}/{match[3]}"


def is_ros2_type(name: str | None) -> bool:
    """Tell whether a type is spelled as in ROS 2: whoever does so expects ROS 2's spelling of times too."""
    match = _TYPE.fullmatch(name) if name is not None else None
    return match is not None and match[2] is not None
