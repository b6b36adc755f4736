"""Unacknowledged messages: reliable messages for a node on the robot that its last checkpoint does not include."""

from collections.abc import Collection

import msgspec

from ppaas.messages import encode
from ppaas.messages.base.message import Message
from ppaas.messages.ppaas_msgs import TopicMessage
from ppaas.nodes.base import Payload
from ppaas.nodes.message_checks import fingerprint

MOST = 100
"""Largest number of messages kept for one node; beyond it the oldest are dropped."""


class UnacknowledgedMessages(msgspec.Struct):
    """Unacknowledged messages for one node by their fingerprints, oldest first."""

    messages: dict[str, TopicMessage] = {}

    def note(self, topic: str, payload: Payload) -> None:
        """Keep a message for the node."""
        message = payload if isinstance(payload, Message) else payload.to_message()
        mark = fingerprint(topic, message)
        self.messages.pop(mark, None)  # sent again: now the newest
        self.messages[mark] = TopicMessage(topic, encode(message).decode())
        while len(self.messages) > MOST:
            del self.messages[next(iter(self.messages))]

    def heard(self, fingerprints: Collection[str]) -> None:
        """Drop the messages that the robot's last checkpoint includes."""
        for mark in fingerprints:
            self.messages.pop(mark, None)

    def all(self) -> list[TopicMessage]:
        """Return the kept messages, oldest first."""
        return list(self.messages.values())
