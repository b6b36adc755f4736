"""What must arrive at a node that the robot runs, until a state is known that has it in it."""

from collections.abc import Collection

import msgspec

from ppaas.messages import encode
from ppaas.messages.message import Message
from ppaas.messages.ppaas_msgs import TopicMessage
from ppaas.nodes.base import Payload
from ppaas.nodes.message_fingerprint import fingerprint

MOST = 100
"""Messages that are kept of one node; of more the oldest are let go."""


class Unheard(msgspec.Struct):
    """Messages for one node, the oldest first, by their fingerprints."""

    messages: dict[str, TopicMessage] = {}

    def note(self, topic: str, payload: Payload) -> None:
        """Keep what comes for the node."""
        message = payload if isinstance(payload, Message) else payload.to_message()
        mark = fingerprint(topic, message)
        self.messages.pop(mark, None)  # said again: it is the newest now
        self.messages[mark] = TopicMessage(topic, encode(message).decode())
        while len(self.messages) > MOST:
            del self.messages[next(iter(self.messages))]

    def heard(self, fingerprints: Collection[str]) -> None:
        """Let go of what the robot's last state has in it."""
        for mark in fingerprints:
            self.messages.pop(mark, None)

    def all(self) -> list[TopicMessage]:
        """Return what is kept."""
        return list(self.messages.values())
