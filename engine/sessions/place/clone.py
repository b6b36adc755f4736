"""Clone of a robot, as those within its process that use it see it: the sessions of its clients, and its links."""

from collections.abc import Callable
from typing import Protocol

from engine.links.open_calls import Outcome
from engine.protocols.robot_link import NodeInfo, ServiceInfo, TopicInfo
from ppaas.errors import PPaaSError


class CloneListener(Protocol):
    """User of a clone. The clone calls it in the middle of its work: a method must not use the clone in turn."""

    @property
    def applied(self) -> int:
        """Number of its last message that the clone has processed."""
        ...

    @property
    def is_slow(self) -> bool:
        """Whether messages that may be lost are to be dropped for it."""
        ...

    def wants(self, topic: str) -> bool:
        """Return whether it is subscribed to a topic."""
        ...

    def published(self, topic: str, payload: bytes, client: int = 0) -> None:
        """Take a message, as JSON; with a client, a latched one for that client alone, which has just subscribed."""
        ...

    def map_replaced(self) -> None:
        """Note that the map was replaced, and only its changes were published."""
        ...

    def topic_added(self, topic: TopicInfo, node: str) -> None:
        """Note a topic that a node has begun to publish."""
        ...

    def topic_removed(self, topic: str) -> None:
        """Note that a node publishes a topic no longer that it had begun to publish."""
        ...

    def nodes_changed(self, services: list[ServiceInfo], nodes: list[NodeInfo]) -> None:
        """Note the current services and nodes."""
        ...

    def acknowledged(self, sequence: int) -> None:
        """Note that all its messages up to a number are processed and in a stored checkpoint."""
        ...


class Clone(Protocol):
    """Graph of a clone."""

    def topics(self) -> list[TopicInfo]:
        """Return its topics."""
        ...

    def services(self) -> list[ServiceInfo]:
        """Return its services."""
        ...

    def nodes(self) -> list[NodeInfo]:
        """Return its nodes."""
        ...

    def add_listener(self, listener: CloneListener) -> None:
        """Notify a user of what happens from now on."""
        ...

    def subscribe(self, listener: CloneListener, topic: str, client: int) -> None:
        """Send a user the messages of a topic that it wants; a latched one is sent at once, for the client named."""
        ...

    def unsubscribe(self, topic: str) -> None:
        """Note that a user does not want a topic any more."""
        ...

    def deliver(self, topic: str, payload: bytes, client: int, sequence: int) -> PPaaSError | None:
        """Take a message, as JSON; with sequence 0 it may be lost. Return the reason if the clone refuses it."""
        ...

    def call(self, service: str, payload: bytes, reply: Callable[[Outcome], None]) -> None:
        """Call a service; ``reply`` is called with the response as JSON or the error, now or later."""
        ...
