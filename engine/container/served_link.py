"""Link that a clone serves, to the master or an endpoint: what the clone tells it, in frames."""

from engine.links.frame_writer import FrameWriter
from engine.protocols import robot_link
from engine.protocols.robot_link import NodeInfo, ServiceInfo, TopicInfo

MAX_WAITING = 1 << 20
"""Bytes queued for a slow endpoint above which messages are dropped whose topic is neither latched nor lasting, or is
repeated."""

FarEnd = FrameWriter[robot_link.FromContainer]
"""The other end of a link."""


class ServedLink:
    """A link with its subscriptions, which listens to the clone.

    Parameters
    ----------
    end : FarEnd
        Its other end.
    applied : int
        Sequence number of the last message of this link that the clone has processed.

    Attributes
    ----------
    wanted : set of str
        Topics that it is subscribed to.
    """

    def __init__(self, end: FarEnd, applied: int = 0) -> None:
        self.end = end
        self.applied = applied
        self.wanted: set[str] = set()

    @property
    def is_slow(self) -> bool:
        """Whether messages that may be lost are to be dropped for it."""
        return self.end.waiting > MAX_WAITING

    def wants(self, topic: str) -> bool:
        """Return whether it is subscribed to a topic."""
        return topic in self.wanted

    def published(self, topic: str, payload: bytes, client: int = 0) -> None:
        """Send a message; with a client, a latched one for that client alone."""
        self.end.write(robot_link.Published(topic, payload, client or None))

    def map_replaced(self) -> None:
        """Send the news that only changes of the map were published."""
        self.end.write(robot_link.MapReplaced())

    def topic_added(self, topic: TopicInfo, node: str) -> None:
        """Send the news of a topic that a node has begun to publish."""
        self.end.write(robot_link.TopicAdded(topic, node))

    def topic_removed(self, topic: str) -> None:
        """Send the news that a topic was removed."""
        self.end.write(robot_link.TopicRemoved(topic))

    def nodes_changed(self, services: list[ServiceInfo], nodes: list[NodeInfo]) -> None:
        """Send the current services and nodes."""
        self.end.write(robot_link.NodesChanged(services, nodes))

    def acknowledged(self, sequence: int) -> None:
        """Send the news that all messages up to a number are in a stored checkpoint."""
        self.end.write(robot_link.Ack(sequence))
