"""Place of a robot, as its clients share it: topics, services and actions of the clone and of the clients."""

from collections.abc import Callable, Collection

from engine.links.container_link import ContainerLink
from engine.links.open_calls import Done
from engine.sessions.place.client_actions import ActionProvider, ClientActions
from engine.sessions.place.client_health import ClientHealth
from engine.sessions.place.client_services import ClientServices, Provider
from engine.sessions.place.client_topics import ClientTopics
from ppaas.clock import monotonic
from ppaas.diagnosis.observations.facts import LinkFacts
from ppaas.errors import Conflict, NotFound
from ppaas.nodes.frames import BASE_LINK
from ppaas.wire.actions import actions

LIST_PERIOD = 1.0
"""Time for which the list of topics in error texts is not rebuilt [s]."""


class Place(ContainerLink):
    """Shared by all clients of one place: its container link, subscriptions, client topics and client services.

    Parameters
    ----------
    key : str
        Name of the place.
    base_frame : str
        Frame in which the robot is driven.
    """

    def __init__(self, key: str, base_frame: str = BASE_LINK) -> None:
        super().__init__()
        self.key = key
        self.base_frame = base_frame
        self.round_trip: float | None = None
        self.client_topics = ClientTopics()
        self.client_services = ClientServices()
        self.client_actions = ClientActions()
        self.health = ClientHealth()
        self._listed: list[str] = []
        self._listed_until = 0.0

    # -- frames of the clone -------------------------------------------------------------------------------------------

    def _declared(self, topic: str) -> None:
        self.client_topics.drop(topic)

    def _served(self, services: Collection[str]) -> None:
        self.client_services.overtaken(services)

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
        PPaaSError
            The place was closed; the reason for it.
        """
        if service in self.services:
            raise Conflict(f"service {service!r} is provided by the clone: choose another name")
        if self._closed is not None:
            raise self._closed
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
        PPaaSError
            The place was closed; the reason for it.
        """
        if action in actions(self.topic_types()):
            raise Conflict(f"there is an action {action!r} already: choose another name")
        if self._closed is not None:
            raise self._closed
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
