"""Base classes of ROS messages and service types, and descriptions of their fields."""

from enum import IntEnum
from typing import Annotated, ClassVar, NamedTuple, Protocol

import msgspec
from msgspec import inspect

# ROS types that Python's types do not distinguish. Fields without such a note are float64, int32, string or bool.
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
    """Fields in the order of the definition in ROS; empty if the class has the same; its defaults are last."""

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


NO_ARRAY = -1
"""Annotated length of a field that is not an array."""


def struct_of(message: type[Message]) -> inspect.StructType:
    """Return the description of a message type."""
    described = inspect.type_info(message)
    assert isinstance(described, inspect.StructType)
    return described


def message_of(kind: inspect.Type) -> type[Message] | None:
    """Return the message type that a type without annotations is; None if it is another one."""
    return kind.cls if isinstance(kind, inspect.StructType) and issubclass(kind.cls, Message) else None


def plain(kind: inspect.Type) -> tuple[inspect.Type, int, str]:
    """Return a type without its annotations, the annotated array length, and the annotated ROS type."""
    length, ros = NO_ARRAY, ""
    while True:
        if isinstance(kind, inspect.Metadata):
            notes = kind.extra or {}
            kind, length, ros = kind.type, notes.get("length", length), notes.get("ros", ros)
        elif isinstance(
            kind, inspect.UnionType
        ):  # a number or null, or a list or encoded JSON: the first is ROS's type
            kind = kind.types[0]
        else:
            return kind, length, ros
