"""Messages of topics in bytes of ROS, for clients that subscribe with ``compression: cbor-raw``."""

from contextlib import suppress
from functools import cache, lru_cache
from typing import Final

from ppaas.errors import InvalidInput, UnknownType
from ppaas.wire.binary.cbor import RosType
from ppaas.wire.ros.types import ROS_1, ros_types

ROS_2: Final = "jazzy"
"""Release of ROS 2 whose messages are sent; messages of the clone's topics are the same since Humble."""


@cache
def read_types() -> None:
    """Read the types of ROS 1 and ROS 2, which takes most of a second once; without ``rosbags``, do nothing."""
    with suppress(InvalidInput):
        for release in (ROS_1, ROS_2):
            ros_types(release)


def are_types_read() -> bool:
    """Return whether `read_types` has been called, so that `serialize` is fast."""
    return read_types.cache_info().currsize > 0


@lru_cache(maxsize=2)
def serialize(message: bytes, kind: RosType) -> bytes:
    """Return a message, given as JSON, in bytes of ROS.

    All subscribers of its topic share them: the ones on ROS 1, and the ones on ROS 2.

    Raises
    ------
    UnknownType
        The type is not known, or none of this version of ROS.
    MalformedMessage
        The message is not of this type, as one of a client may be.
    InvalidInput
        ``rosbags`` is not installed; the text says how to install it.
    """
    if kind.name is None:
        raise UnknownType("the topic has no type yet")
    return ros_types(ROS_2 if kind.ros2 else ROS_1).encode_json(kind.name, message)
