"""Messages of MCAP files as JSON of rosbridge: CDR of ROS 2, the serialization of ROS 1, or JSON."""

from collections import Counter

from ppaas.errors import MalformedMessage, UnknownType
from ppaas.recording.reader import Channel, Message
from ppaas.wire.ros import ros_types
from ppaas.wire.ros.own_types import types_with

MOST_SKIPPED = 256
"""Largest number of topics whose skipped messages are counted."""

_OF_OLD_ROBOTS = {"tf/tfMessage": "tf2_msgs/TFMessage"}
"""Types of early ROS 1, and today's types with the same fields."""


class McapDecoder:
    """Decoder of the messages of one file.

    Attributes
    ----------
    skipped : Counter of str
        Number of messages that could not be decoded, by topic and reason.
    """

    def __init__(self) -> None:
        self.skipped: Counter[str] = Counter()

    def json(self, message: Message) -> bytes | None:
        """Return a message as JSON; None if its type is unknown or it is not one of its type, which is counted."""
        try:
            return decoded(message.channel, message.data)
        except (UnknownType, MalformedMessage) as error:
            self.skip(message, str(error))
            return None

    def skip(self, message: Message, why: str) -> None:
        """Count a message that cannot be used."""
        reason = f"{message.channel.topic[:64]}: {why[:200]}"
        if reason in self.skipped or len(self.skipped) < MOST_SKIPPED:
            self.skipped[reason] += 1


def decoded(channel: Channel, data: bytes) -> bytes:
    """Return a message of a channel as JSON.

    Raises
    ------
    UnknownType
        Its encoding or its type is unknown.
    MalformedMessage
        It is not a message of its type.
    """
    match channel.encoding:
        case "cdr":
            return types_with(channel.type).decode_json(channel.type, data)
        case "ros1":
            return ros_types("noetic").decode_json(_OF_OLD_ROBOTS.get(channel.type, channel.type), data)
        case "json":
            return data
    raise UnknownType(f"unknown encoding {channel.encoding[:32]!r}; known: cdr, ros1, json")
