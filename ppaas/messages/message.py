"""The base of all messages, and what a service type is."""

from enum import IntEnum
from typing import Annotated, ClassVar, NamedTuple, Protocol

import msgspec

# What a field is in ROS where Python says less; without one of these it is float64, int32, string or bool.
Float32 = Annotated[float, msgspec.Meta(extra={"ros": "float32"})]
Int8 = Annotated[int, msgspec.Meta(extra={"ros": "int8"})]
UInt8 = Annotated[int, msgspec.Meta(extra={"ros": "uint8"})]
UInt32 = Annotated[int, msgspec.Meta(extra={"ros": "uint32"})]
Covariance = Annotated[list[float], msgspec.Meta(extra={"length": 36})]
"""Row-major, 6×6."""


class Message(msgspec.Struct, gc=False):
    """Base of every ROS message. Its module is its ROS package, its class name its type."""

    constants: ClassVar[type[IntEnum] | None] = None
    """The constants that its definition names, each a uint8."""


class Lazy(Protocol):
    """Something that becomes a message only where it leaves its home: a map, a plan.

    Inside one home it travels by reference, so a million cells are never copied from node to node.
    """

    def to_message(self) -> Message:
        """Return the message."""
        ...


class ServiceType(NamedTuple):
    """A ROS service type: its name and the two messages of which it is made."""

    name: str
    request: type[Message]
    response: type[Message]


class Empty(Message):
    """``std_msgs/Empty``, and the answer of services that have none."""
