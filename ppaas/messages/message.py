"""Base classes of ROS messages and service types."""

from enum import IntEnum
from typing import Annotated, ClassVar, NamedTuple, Protocol

import msgspec

# ROS types that Python's types do not tell apart. Fields without such a note are float64, int32, string or bool.
Float32 = Annotated[float, msgspec.Meta(extra={"ros": "float32"})]
Int8 = Annotated[int, msgspec.Meta(extra={"ros": "int8"})]
UInt8 = Annotated[int, msgspec.Meta(extra={"ros": "uint8"})]
UInt32 = Annotated[int, msgspec.Meta(extra={"ros": "uint32"})]
Covariance = Annotated[list[float], msgspec.Meta(extra={"length": 36})]
"""6 × 6 covariance matrix, row-major."""


class Message(msgspec.Struct, gc=False):
    """Base of all ROS messages. The module is the ROS package, the class name is the type."""

    constants: ClassVar[type[IntEnum] | None] = None
    """Constants of the message definition, each a uint8."""


class Lazy(Protocol):
    """Value that is converted to a message only when it leaves its process: a map, a plan.

    Within the process, nodes pass it by reference, so a million cells are not copied from node to node.
    """

    def to_message(self) -> Message:
        """Return the message."""
        ...


class ServiceType(NamedTuple):
    """ROS service type: its name, request type and response type."""

    name: str
    request: type[Message]
    response: type[Message]


class Empty(Message):
    """``std_msgs/Empty``, and the empty request or response of a service."""
