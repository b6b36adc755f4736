"""Validation of ROS names that clients send: topics, services, nodes and types."""

import re
from collections.abc import Callable, Iterable
from typing import Literal

from ppaas.errors import MalformedMessage, UnknownType
from ppaas.messages.base.spelling import camera_to_ros2, to_ros2
from ppaas.messages.registry import PACKAGES_OF_ROS_2

_NAME = re.compile(r"(?:/|~/?)?[A-Za-z_]\w*(/\w+)*", re.ASCII)
_TYPE = re.compile(r"([A-Za-z]\w*)/(?:(msg|srv|action)/)?([A-Za-z]\w*)", re.ASCII)
_PACKAGES_OF_ROS_1 = {ros1: ros2 for ros2, ros1 in PACKAGES_OF_ROS_2.items()}
MAX_NAME = 255

CLIENTS = "rosbridge_websocket"
"""Node that represents all clients together, as in rosbridge; their private names (``~name``) are below it."""


def normalise(name: str) -> str:
    """Return a graph name without its leading slash, the form used inside the cloud.

    Relative names start at the root, as there. A private name, ``~name`` or ``~/name``, is below the node of the
    clients.

    Raises
    ------
    MalformedMessage
        It is not a ROS graph name, or longer than ``MAX_NAME`` characters.
    """
    if len(name) > MAX_NAME or not _NAME.fullmatch(name):
        raise MalformedMessage(f"not a ROS graph name: {name[:64]!r}")
    return f"{CLIENTS}/{name[1:].removeprefix('/')}" if name.startswith("~") else name.removeprefix("/")


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
    return f"{PACKAGES_OF_ROS_2.get(match[1], match[1])}/{match[3]}"


def ros2_type(name: str, kind: Literal["msg", "srv", "action"]) -> str:
    """Return a type name as spelled in ROS 2, ``package/msg/Name``; it is given as spelled in ROS 1."""
    package, _, rest = name.partition("/")
    return f"{_PACKAGES_OF_ROS_1.get(package, package)}/{kind}/{rest}"


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


class NameScope:
    """Names as the software of one robot spells them: names below its namespace are the clone's.

    So a robot whose nodes run below ``/tb3_1`` publishes ``/tb3_1/scan``, and the clone gets ``scan``.

    Parameters
    ----------
    namespaces : iterable of str
        Namespaces of the robot, without leading slashes.
    """

    def __init__(self, namespaces: Iterable[str] = ()) -> None:
        self._prefixes = tuple(f"{namespace}/" for namespace in namespaces)

    def resolve(self, name: str) -> str:
        """Return a graph name without leading slash and namespace; raises as ``normalise``."""
        return self.without_namespace(normalise(name))

    def without_namespace(self, name: str) -> str:
        """Return a name of anything, such as a parameter, without slash and namespace if it has a namespace."""
        bare = name.removeprefix("/")
        for prefix in self._prefixes:
            if bare.startswith(prefix):
                return bare.removeprefix(prefix)
        return name

    def callee(self, name: str) -> str:
        """Return the name of a service or an action, resolved.

        An id that old clients append after ``#`` is cut off, as in rosbridge_suite.
        """
        return self.resolve(name.partition("#")[0])
