"""Two nodes of one graph that answer each other: round-trip time of messages within a container."""

from typing import ClassVar

from ppaas.clock import monotonic
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, PoseWithCovarianceStamped
from ppaas.nodes.base import Node, Payload, Topic
from ppaas.nodes.graph import Graph

PING, PONG = Topic("ping", PoseWithCovarianceStamped), Topic("pong", PoseWithCovarianceStamped)

MESSAGE = PoseWithCovarianceStamped(Header(frame_id="map"), PoseWithCovariance(Pose.of(Pose2D(1.0, 2.0, 0.5))))


class PongNode(Node):
    """Publishes each message that it receives."""

    name: ClassVar[str] = "answerer"
    subscribes: ClassVar[tuple[Topic, ...]] = (PING,)
    publishes: ClassVar[tuple[Topic, ...]] = (PONG,)

    def on_message(self, topic: str, message: Payload) -> None:
        """Publish the message."""
        self.context.publish(PONG.name, message)


class PingNode(Node):
    """Publishes a message, and records the time of the answer.

    Attributes
    ----------
    answered : float
        Time of the last answer [monotonic s].
    """

    name: ClassVar[str] = "asker"
    subscribes: ClassVar[tuple[Topic, ...]] = (PONG,)
    publishes: ClassVar[tuple[Topic, ...]] = (PING,)
    answered: float = 0.0

    def on_message(self, topic: str, message: Payload) -> None:
        """Record the time of the answer."""
        self.answered = monotonic()

    def ask(self) -> float:
        """Publish a message; return the time until its answer [s]."""
        began = monotonic()
        self.context.publish(PING.name, MESSAGE)
        return self.answered - began


def in_one_container(rounds: int) -> list[float]:
    """Return the round-trip times of a pose between two nodes of a graph [s]."""
    graph = Graph()
    graph.add(PongNode)
    asker = graph.add(PingNode)
    return [asker.ask() for _ in range(rounds)]
