"""Base classes of ROS messages and service types."""

from enum import IntEnum
from typing import Annotated, ClassVar, NamedTuple, Protocol

import msgspec

# ROS types that Python's types do not tell apart. Fields without such a note are float64, int32, string or bool.
Float32 = Annotated[float, msgspec.Meta(extra={"ros": "float32"})]
Int8 = Annotated[int, msgspec.Meta(extra={"ros": "int8"})]
Int16 = Annotated[int, msgspec.Meta(extra={"ros": "int16"})]
UInt8 = Annotated[int, msgspec.Meta(extra={"ros": "uint8"})]
UInt16 = Annotated[int, msgspec.Meta(extra={"ros": "uint16"})]
UInt32 = Annotated[int, msgspec.Meta(extra={"ros": "uint32"})]
Covariance = Annotated[list[float], msgspec.Meta(extra={"length": 36})]
"""6 × 6 covariance matrix, row-major."""


class Message(msgspec.Struct, gc=False, forbid_unknown_fields=True):
    """Base of all ROS messages. The module is the ROS package, the class name is the type.

    Messages forbid unknown fields, as rosbridge_suite does: so ``decode`` recognizes the spellings of ROS 2, and a
    client that misspells a field gets an error.
    """

    constants: ClassVar[type[IntEnum] | None] = None
    """Constants of the message definition, each a uint8."""

    ros_order: ClassVar[tuple[str, ...]] = ()
    """Fields in the order of the definition in ROS; empty if it is that of the class, in which defaults are last."""

    @classmethod
    def field_names(cls) -> tuple[str, ...]:
        """Return the names of the fields in the order of the definition in ROS."""
        return cls.ros_order or cls.__struct_encode_fields__


class OwnMessage(Message, forbid_unknown_fields=False):
    """Base of messages between parts of this project, whose releases may differ: unknown fields are ignored."""


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
