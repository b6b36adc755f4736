"""The base of all messages, and what a service type is."""

from typing import NamedTuple, Protocol

import msgspec


class Message(msgspec.Struct, gc=False):
    """Base of every ROS message. Its module is its ROS package, its class name its type."""


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
