"""Place of a robot, as its clients share it: topics, services and actions of the clone and of the clients."""

import asyncio
from collections import deque
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from engine.links.open_calls import Done
from engine.links.shared_place import SharedPlace
from engine.protocols.robot_link import NodeInfo, ServiceInfo, TopicInfo
from engine.sessions.place.client_actions import ActionProvider, ClientActions
from engine.sessions.place.client_health import ClientHealth
from engine.sessions.place.client_services import ClientServices, Provider
from engine.sessions.place.client_topics import ClientTopics
from engine.sessions.place.clone import Clone
from ppaas.clock import monotonic
from ppaas.diagnosis.observations.facts import LinkFacts
from ppaas.errors import Conflict, NotFound, Unavailable
from ppaas.nodes.frames import BASE_LINK
from ppaas.wire.actions import actions

LIST_PERIOD = 1.0
"""Time for which the list of topics in error texts is not rebuilt [s]."""


class Place(SharedPlace):
    """Shared by all clients of one place: its clone, subscriptions, client topics and client services.

    The clone takes messages and calls at once. What it reports to clients waits in one queue until it is done with what
    it does now; so a client never uses the clone in the middle of that, and hears everything in order.

    Parameters
    ----------
    key : str
        Name of the place.
    base_frame : str
        Frame in which the robot is driven.
    """

    is_slow = False
    """Nothing is dropped on the way from the clone: the outbox of each client is limited."""

    def __init__(self, key: str, base_frame: str = BASE_LINK) -> None:
        super().__init__()
        self.key = key
        self.base_frame = base_frame
        self.round_trip: float | None = None
        self.client_topics = ClientTopics()
        self.client_services = ClientServices()
        self.client_actions = ClientActions()
        self.health = ClientHealth()
        self._clone: Clone | None = None
        self._news: deque[tuple[Callable[..., object], tuple[Any, ...]]] = deque()
        self._is_due = False
        self._listed: list[str] = []
        self._listed_until = 0.0

    def begin(self, clone: Clone) -> None:
        """Use a clone from now on."""
        self._clone = clone
        self.topics = {topic.name: topic for topic in clone.topics()}
        self._nodes_changed(clone.services(), clone.nodes())
        for topic in self.topics:
            self.client_topics.drop(topic)  # a name belongs to the clone, also if a client had it before
        clone.add_listener(self)
        for topic in self._hearers:
            clone.subscribe(self, topic, 0)

    # -- to the clone --------------------------------------------------------------------------------------------------

    def deliver(self, topic: str, payload: bytes, client: int, *, must_arrive: bool) -> int:
        """Give the clone a message; return its sequence number, or 0 if it need not arrive.

        Raises
        ------
        QuotaExceeded
            Too many messages are unacknowledged: the client must slow down.
        Unavailable
            There is no clone yet.
        """
        clone = self._has_clone()
        sequence = self._unacknowledged.add(len(payload)) if must_arrive else 0
        refusal = clone.deliver(topic, payload, client, sequence)
        if refusal is not None:  # it waits, too: what nodes published before they refused it comes first
            self._later(self._refused, client, topic, refusal, sequence)
        return sequence

    def _has_clone(self) -> Clone:
        if self._clone is None:
            raise Unavailable("the robot has no clone yet; try again")
        return self._clone

    def _listen(self, topic: str, client: int) -> None:
        if self._clone is not None:
            self._clone.subscribe(self, topic, client)

    def _ignore(self, topic: str) -> None:
        if self._clone is not None:
            self._clone.unsubscribe(topic)

    def _ask(self, number: int, service: str, payload: bytes) -> None:
        self._has_clone().call(service, payload, partial(self._later, self._calls.end, number))

    # -- from the clone ------------------------------------------------------------------------------------------------

    @property
    def applied(self) -> int:
        """Number of the last message: the clone processes each at once."""
        return self._unacknowledged.last

    def wants(self, topic: str) -> bool:
        """Return whether a client is subscribed to a topic."""
        return topic in self._hearers

    def published(self, topic: str, payload: bytes, client: int = 0) -> None:
        """Take a message; with a client, a latched one for that client alone."""
        self._later(self._published, topic, payload, client)

    def map_replaced(self) -> None:
        """Note that only changes of the map were published."""
        self._later(self._map_replaced)

    def topic_added(self, topic: TopicInfo, node: str) -> None:
        """Note a new topic, which clients may have had by the same name."""
        self._later(self._topic_added, topic, node)

    def topic_removed(self, topic: str) -> None:
        """Note that a topic was removed."""
        self._later(self._topic_removed, topic)

    def nodes_changed(self, services: list[ServiceInfo], nodes: list[NodeInfo]) -> None:
        """Note the current services and nodes."""
        self._later(self._nodes_changed, services, nodes)

    def acknowledged(self, sequence: int) -> None:
        """Note that a checkpoint has all messages up to a number."""
        self._later(self._acknowledged, sequence)

    def _later(self, work: Callable[..., object], *args: Any) -> None:
        self._news.append((work, args))
        self._schedule()

    def _schedule(self) -> None:
        if not self._is_due:
            self._is_due = True
            asyncio.get_running_loop().call_soon(self._pass_on)

    def _pass_on(self) -> None:
        """Do what has waited; what comes meanwhile is done in the next turn of the loop."""
        self._is_due = False
        try:
            for _ in range(len(self._news)):
                work, args = self._news.popleft()
                work(*args)
        finally:  # also after a fault, which must not hold back the rest
            if self._news:
                self._schedule()

    def _topic_added(self, topic: TopicInfo, node: str) -> None:
        self.client_topics.drop(topic.name)
        super()._topic_added(topic, node)

    def _nodes_changed(self, services: Iterable[ServiceInfo], nodes: Iterable[NodeInfo]) -> None:
        super()._nodes_changed(services, nodes)
        self.client_services.overtaken(self.services)

    def link_facts(self) -> LinkFacts:
        """Return the facts of the robot's connection, for its diagnosis."""
        return self.health.facts(self._hearers, self.client_topics.types(), self.round_trip)

    # -- clients -------------------------------------------------------------------------------------------------------

    def leave(self, client: int) -> None:
        """Remove a client with its subscriptions, topics, services and actions."""
        self.client_topics.leave(client)
        self.client_services.leave(client)
        self.client_actions.leave(client)
        self.health.left(client)
        super().leave(client)

    def hear(self, topic: str, client: int, kind: str | None = None) -> None:
        """Subscribe a client to a topic of the clone or of a client, which need not exist yet.

        Raises
        ------
        Conflict
            The topic has another type than ``kind``.
        """
        if kind is not None:
            self.check_topic_type(topic, kind)
        self.subscribe(topic, client)
        if (last := self.client_topics.latched(topic)) is not None:
            self._published(topic, last, client)

    def client_topic_type(self, topic: str) -> str | None:
        """Return the type of a topic of a client, by its name in ROS 1; None if there is none."""
        return self.client_topics.type_of(topic)

    def client_topic_types(self) -> dict[str, str]:
        """Return the topics of clients and their types, by the names of ROS 1."""
        return self.client_topics.types()

    def client_service_type(self, service: str) -> str | None:
        """Return the type of a service of a client, by its name in ROS 1; None if there is none."""
        return self.client_services.type_of(service)

    def offered_services(self) -> dict[str, str]:
        """Return the services of clients and their types, by the names of ROS 1."""
        return self.client_services.types()

    def offered_actions(self) -> dict[str, str]:
        """Return the actions of clients and their types, ``package/Name``."""
        return self.client_actions.types()

    def advertise(self, topic: str, kind: str, client: int, identity: str | int | None, *, latch: bool) -> None:
        """Advertise a topic of a client; a topic that the clone does not have is created.

        Raises
        ------
        Conflict
            The topic has another type.
        QuotaExceeded
            The clients advertise too many topics.
        """
        if topic in self.topics:
            self.check_topic_type(topic, kind)
        else:
            self.client_topics.advertise(topic, kind, (client, identity), latch=latch)

    def unadvertise(self, topic: str, client: int, identity: str | int | None) -> None:
        """Withdraw an advertisement, or without an id all of a client's for this topic.

        Raises
        ------
        NotFound
            The client does not advertise it.
        """
        if topic not in self.topics:
            self.client_topics.unadvertise(topic, (client, identity))

    def publish(self, topic: str, payload: bytes, client: int, *, must_arrive: bool, latch: bool = False) -> int:
        """Publish a message of a client; return its sequence number if the clone must acknowledge it, else 0.

        Raises
        ------
        NotFound
            There is no such topic.
        MalformedMessage
            The topic is one of a client, and the message is not of its type.
        QuotaExceeded
            Too many messages are unacknowledged, or the latched messages are too large.
        """
        if topic in self.client_topics:
            self._published(topic, self.client_topics.take(topic, payload, latch=latch))
            return 0
        if self.topics and topic not in self.topics:
            raise NotFound("topic", topic, self._topic_list())
        return self.deliver(topic, payload, client, must_arrive=must_arrive)

    def _topic_list(self) -> list[str]:
        """Return all topics for an error text, which a client can cause thousands of times a second."""
        now = monotonic()
        if now >= self._listed_until:
            self._listed, self._listed_until = sorted(self.topic_types()), now + LIST_PERIOD
        return self._listed

    def advertise_service(
        self, service: str, kind: str, client: int, provider: Provider, *, ros2: bool = False
    ) -> None:
        """Advertise a service of a client, who spells messages as in ROS 2 or in ROS 1.

        Raises
        ------
        Conflict
            The clone provides a service of this name.
        QuotaExceeded
            The clients advertise too many services.
        """
        if service in self.services:
            raise Conflict(f"service {service!r} is provided by the clone: choose another name")
        self.client_services.advertise(service, kind, client, provider, ros2=ros2)

    def advertise_action(
        self, action: str, kind: str, client: int, provider: ActionProvider, *, ros2: bool = False
    ) -> None:
        """Advertise an action of a client, who spells messages as in ROS 2 or in ROS 1.

        Raises
        ------
        Conflict
            There is an action of this name already, of the clone or by topics of clients.
        QuotaExceeded
            The clients advertise too many actions.
        """
        if action in actions(self.topic_types()):
            raise Conflict(f"there is an action {action!r} already: choose another name")
        self.client_actions.advertise(action, kind, client, provider, ros2=ros2)

    def begin_call(self, service: str, payload: bytes, timeout: float, done: Done) -> Callable[[], object]:
        """Call a service of the clone or of a client; ``done`` is called once with the response as JSON, or an error.

        Returns
        -------
        callable
            Cancels the call: ``done`` is not called any more.

        Raises
        ------
        MalformedMessage
            The service is one of a client, and the request is not of its type.
        Unavailable
            No container is connected, or the client that provides the service is too slow to take calls.
        """
        if service not in self.services and service in self.client_services:
            return self.client_services.begin(service, payload, timeout, done)
        return super().begin_call(service, payload, timeout, done)
