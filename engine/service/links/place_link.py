"""A place, as its clients see it: a robot's socket, operators' sockets, a REST call.

Clients talk to the place. When its container is lost they notice nothing but a pause: subscriptions are made again with
the next one, and what must arrive is sent again.
"""

import asyncio
import itertools
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable
from typing import Protocol

from engine.protocols import robot_link
from engine.service.links.client_services import ClientServices, Provider
from engine.service.links.client_topics import ClientTopics, check_type
from engine.service.links.container_link import ContainerLink
from engine.service.links.open_calls import Done, Outcome
from ppaas.errors import Conflict, NotFound, PPaaSError


class Listener(Provider, Protocol):
    """A client, as a place sees it. None of these may block."""

    def published(self, topic: str, payload: bytes) -> None:
        """Take a message of a topic that the client subscribed to, as JSON."""
        ...

    def refused(self, topic: str, error: PPaaSError, sequence: int) -> None:
        """Learn that the clone did not take a message of this client; the sequence is what ``publish`` returned."""
        ...

    def closed(self, reason: PPaaSError) -> None:
        """Learn that the place is no more."""
        ...


class PlaceLink(ContainerLink):
    """What the clients of one place share."""

    def __init__(self, key: str) -> None:
        super().__init__()
        self.key = key
        self.round_trip: float | None = None
        self._clients: dict[int, Listener] = {}
        self._client_numbers = itertools.count(1)
        self._hearers: defaultdict[str, set[int]] = defaultdict(set)
        self.client_topics = ClientTopics()
        self.client_services = ClientServices()

    # -- what the container says ---------------------------------------------------------------------------------------

    def _published(self, topic: str, payload: bytes, client: int | None = None) -> None:
        hearers = self._hearers.get(topic, set()) if client is None else {client}
        for listener in [self._clients[n] for n in hearers if n in self._clients]:
            listener.published(topic, payload)

    def _wanted(self) -> Iterable[str]:
        return self._hearers

    def _refused(self, client: int, topic: str, error: PPaaSError, sequence: int) -> None:
        if client in self._clients:
            self._clients[client].refused(topic, error, sequence)

    def _declared(self, topic: str) -> None:
        self.client_topics.drop(topic)

    def _served(self, services: Collection[str]) -> None:
        self.client_services.overtaken(services)

    def close(self, reason: PPaaSError) -> None:
        """Tell all clients that the place is no more."""
        super().close(reason)
        for client in tuple(self._clients.values()):
            client.closed(reason)
        self._clients.clear()

    def note_round_trip(self, seconds: float) -> None:
        """Note how far the robot is: the round trip of a ping [s]."""
        self.round_trip = seconds

    # -- the clients ---------------------------------------------------------------------------------------------------

    def join(self, listener: Listener) -> int:
        """Add a client; return its number. Where the place is no more, the client is told at once."""
        number = next(self._client_numbers)
        if self._closed is None:
            self._clients[number] = listener
        else:
            listener.closed(self._closed)
        return number

    @property
    def clients(self) -> int:
        """How many clients there are."""
        return len(self._clients)

    def leave(self, client: int) -> None:
        """Forget a client, its subscriptions and all that it offers."""
        self._clients.pop(client, None)
        self.client_topics.leave(client)
        self.client_services.leave(client)
        for topic in tuple(self._hearers):
            self.unsubscribe(topic, client)

    def subscribe(self, topic: str, client: int, kind: str | None = None) -> None:
        """Let a client hear a topic. One that is not there yet is heard as soon as it is.

        Raises
        ------
        Conflict
            The topic carries another type than this one.
        """
        has = self.topic_type(topic)
        if kind is not None and has is not None:
            check_type(topic, has, kind)
        self._hearers[topic].add(client)
        self._write(robot_link.Subscribe(topic, client))
        if (last := self.client_topics.latched(topic)) is not None:
            self._published(topic, last, client)

    def topic_type(self, topic: str) -> str | None:
        """Return the type of a topic of the clone or of a client, as ROS 1 spells it; None if there is none."""
        known = self.topics.get(topic)
        return known.type if known is not None else self.client_topics.type_of(topic)

    def topic_types(self) -> dict[str, str]:
        """Return all topics, those of clients too, and their types as ROS 1 spells them."""
        return self.client_topics.types() | {name: topic.type for name, topic in self.topics.items()}

    def heard(self) -> frozenset[str]:
        """Return the topics that some client hears, or would if they were there."""
        return frozenset(self._hearers)

    def unsubscribe(self, topic: str, client: int) -> None:
        """Let a client hear a topic no more."""
        hearers = self._hearers.get(topic, set())
        hearers.discard(client)
        if not hearers and self._hearers.pop(topic, None) is not None:
            self._write(robot_link.Unsubscribe(topic))

    def advertise(self, topic: str, kind: str, client: int, identity: str | None, *, latch: bool) -> None:
        """Let a client publish a topic; one that the clone does not know is there from now on.

        Raises
        ------
        Conflict
            The topic carries another type.
        QuotaExceeded
            There are too many topics.
        """
        if topic in self.topics:
            check_type(topic, self.topics[topic].type, kind)
        else:
            self.client_topics.advertise(topic, kind, (client, identity), latch=latch)

    def unadvertise(self, topic: str, client: int, identity: str | None) -> None:
        """Take an advertisement back, or all of a client's for this topic.

        Raises
        ------
        NotFound
            The client does not advertise it.
        """
        if topic not in self.topics:
            self.client_topics.unadvertise(topic, (client, identity))

    def publish(self, topic: str, payload: bytes, client: int, *, must_arrive: bool, latch: bool = False) -> int:
        """Bring a message to whoever it is for; return its sequence number if the clone must acknowledge it, else 0.

        Raises
        ------
        NotFound
            There is no such topic.
        QuotaExceeded
            Too much waits to be acknowledged, or is latched.
        """
        if topic in self.client_topics:
            self.client_topics.take(topic, payload, latch=latch)
            self._published(topic, payload)
            return 0
        if self.topics and topic not in self.topics:
            raise NotFound("topic", topic, list(self.topic_types()))
        return self.deliver(topic, payload, client, must_arrive=must_arrive)

    def advertise_service(self, service: str, kind: str, client: int) -> None:
        """Let a client answer the calls of a service.

        Raises
        ------
        Conflict
            It is a service of the clone.
        QuotaExceeded
            There are too many.
        PPaaSError
            The place was closed, with its reason.
        """
        if service in self.services:
            raise Conflict(f"service {service!r} is the clone's own: choose another name")
        if self._closed is not None:
            raise self._closed
        self.client_services.advertise(service, kind, client, self._clients[client])

    def service_type(self, service: str) -> str | None:
        """Return the type of a service of the clone or of a client, as ROS 1 spells it; None if there is none."""
        known = self.services.get(service)
        return known.type if known is not None else self.client_services.type_of(service)

    def begin_call(self, service: str, payload: bytes, timeout: float, done: Done) -> Callable[[], object]:
        """Call a service of the clone or of a client; ``done`` gets the response as JSON, or why there is none, once.

        Returns
        -------
        callable
            Gives the call up: ``done`` is not called any more.

        Raises
        ------
        Unavailable
            There is no container, or the client that answers is too slow to be asked.
        """
        if service not in self.services and service in self.client_services:
            return self.client_services.begin(service, payload, timeout, done)
        return self._ask(service, payload, timeout, done)

    async def call(self, service: str, payload: bytes, timeout: float) -> bytes:
        """Call a service, as ``begin_call``, and return the response as JSON.

        Raises
        ------
        Unavailable
            There is no container, or it or the client that answers was lost meanwhile, or did not answer in time.
        PPaaSError
            What the service raised.
        """
        answered: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()

        def done(outcome: Outcome) -> None:
            if isinstance(outcome, PPaaSError):
                answered.set_exception(outcome)
            else:
                answered.set_result(outcome)

        give_up = self.begin_call(service, payload, timeout, done)
        try:
            return await answered
        finally:
            give_up()
