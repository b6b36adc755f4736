"""Interface between a client and the local nodes that run beside it on the robot."""

from typing import Protocol

from ppaas.messages import Message


class NearbyNodes(Protocol):
    """Local nodes that exchange messages with a client directly, without the cloud."""

    def published(self, topic: str, message: Message) -> bool:
        """Process a message that the client publishes; return whether it must go to the cloud as well."""
        ...

    def owns(self, topic: str) -> bool:
        """Return whether these nodes are the only publishers of a topic; the client then ignores the cloud's copies."""
        ...
