"""Shared link: the robot link of a container, shared by the clients of one process.

Clients use the link, not a container. When its container is lost, they notice only a pause: subscriptions are repeated
with the next container, and messages that must arrive are sent again.
"""

import asyncio
import itertools
import logging
from abc import abstractmethod
from collections import defaultdict
from collections.abc import Callable, Iterable
from typing import Protocol

from engine.links.container_link import ContainerLink
from engine.links.open_calls import Done, Outcome
from engine.links.topic_types import check_type
from engine.protocols import robot_link
from ppaas.errors import PPaaSError
from ppaas.listener_faults import ListenerFaults
from ppaas.nodes import topics
from ppaas.wire.stamped_twists import may_be_named

logger = logging.getLogger(__name__)


class Listener(Protocol):
    """Client of a link. None of its methods may block; an exception of one is logged and concerns this client alone."""

    def published(self, topic: str, payload: bytes) -> None:
        """Receive a message of a subscribed topic, as JSON."""
        ...

    def refused(self, topic: str, error: PPaaSError, sequence: int) -> None:
        """Handle the refusal of a message of this client; ``sequence`` is the number that ``publish`` returned."""
        ...

    def acknowledged(self, sequence: int) -> None:
        """Handle that a checkpoint has all messages up to a number that ``publish`` returned."""
        ...

    def closed(self, reason: PPaaSError) -> None:
        """Handle the end of the place."""
        ...


class SharedLink(ContainerLink):
    """Clients of a link, their subscriptions, messages and calls."""

    def __init__(self) -> None:
        super().__init__()
        self._clients: dict[int, Listener] = {}
        self._client_numbers = itertools.count(1)
        self._hearers: defaultdict[str, set[int]] = defaultdict(set)
        self._faults = ListenerFaults(logger)

    def _tell(self, clients: Iterable[int], tell: Callable[[Listener], None]) -> None:
        """Call clients, each whatever becomes of the others; they may leave meanwhile."""
        for number in tuple(clients):
            listener = self._clients.get(number)
            if listener is not None:
                self._faults.call(f"client {number}", tell, listener)

    def _acknowledged(self, sequence: int) -> None:
        self._tell(self._clients, lambda listener: listener.acknowledged(sequence))

    # -- frames of the container ---------------------------------------------------------------------------------------

    def _published(self, topic: str, payload: bytes, client: int | None = None) -> None:
        hearers = self._hearers.get(topic, set()) if client is None else {client}
        self._tell(hearers, lambda listener: listener.published(topic, payload))

    def _map_replaced(self) -> None:
        changes = self._hearers.get(topics.MAP_UPDATES.name, set())
        for client in self._hearers.get(topics.MAP.name, set()) - changes:
            self._write(robot_link.Subscribe(topics.MAP.name, client))

    def _wanted(self) -> Iterable[str]:
        return self._hearers

    def _refused(self, client: int, topic: str, error: PPaaSError, sequence: int) -> None:
        self._tell((client,), lambda listener: listener.refused(topic, error, sequence))

    def close(self, reason: PPaaSError) -> None:
        """Close the link and notify all clients."""
        super().close(reason)
        self._tell(self._clients, lambda listener: listener.closed(reason))
        self._clients.clear()

    # -- clients -------------------------------------------------------------------------------------------------------

    def join(self, listener: Listener) -> int:
        """Add a client and return its number. If the link is closed already, the client is notified at once."""
        number = next(self._client_numbers)
        if self._closed is None:
            self._clients[number] = listener
        else:
            listener.closed(self._closed)
        return number

    @property
    def clients(self) -> int:
        """Number of clients."""
        return len(self._clients)

    def leave(self, client: int) -> None:
        """Remove a client with its subscriptions."""
        self._clients.pop(client, None)
        for topic in tuple(self._hearers):
            self.unsubscribe(topic, client)

    def subscribe(self, topic: str, client: int) -> None:
        """Subscribe a client to a topic, which need not exist yet."""
        self._hearers[topic].add(client)
        self._write(robot_link.Subscribe(topic, client))

    def unsubscribe(self, topic: str, client: int) -> None:
        """End a client's subscription to a topic."""
        hearers = self._hearers.get(topic, set())
        hearers.discard(client)
        if not hearers and self._hearers.pop(topic, None) is not None:
            self._write(robot_link.Unsubscribe(topic))

    def heard(self) -> frozenset[str]:
        """Return the topics that clients are subscribed to, whether or not they exist."""
        return frozenset(self._hearers)

    # -- types ---------------------------------------------------------------------------------------------------------

    @abstractmethod
    def client_topic_type(self, topic: str) -> str | None:
        """Return the type of a topic of a client, by its name in ROS 1; None if there is none."""

    @abstractmethod
    def client_topic_types(self) -> dict[str, str]:
        """Return the topics of clients and their types, by the names of ROS 1."""

    @abstractmethod
    def client_service_type(self, service: str) -> str | None:
        """Return the type of a service of a client, by its name in ROS 1; None if there is none."""

    def topic_type(self, topic: str) -> str | None:
        """Return the type of a topic of the clone or of a client, by its name in ROS 1; None if there is none."""
        known = self.topics.get(topic)
        return known.type if known is not None else self.client_topic_type(topic)

    def topic_types(self) -> dict[str, str]:
        """Return all topics of the clone and of clients, with their types by the names of ROS 1."""
        return self.client_topic_types() | {name: topic.type for name, topic in self.topics.items()}

    def service_type(self, service: str) -> str | None:
        """Return the type of a service of the clone or of a client, by its name in ROS 1; None if there is none."""
        known = self.services.get(service)
        return known.type if known is not None else self.client_service_type(service)

    def check_topic_type(self, topic: str, kind: str) -> None:
        """Raise ``Conflict`` unless clients may name a topic by a type; one that does not exist yet may have any."""
        has = self.topic_type(topic)
        if has is not None and not (topic in self.topics and may_be_named(has, kind)):
            check_type(topic, has, kind)

    # -- calls ---------------------------------------------------------------------------------------------------------

    def begin_call(self, service: str, payload: bytes, timeout: float, done: Done) -> Callable[[], object]:
        """Call a service; ``done`` is called once with the response as JSON, or an error.

        Returns
        -------
        callable
            Cancels the call: ``done`` is not called any more.

        Raises
        ------
        Unavailable
            No container is connected.
        """
        return self._ask(service, payload, timeout, done)

    async def call(self, service: str, payload: bytes, timeout: float) -> bytes:
        """Call a service like ``begin_call``, wait, and return the response as JSON.

        Raises
        ------
        Unavailable
            No container is connected, the provider was lost during the call, or it did not answer in ``timeout`` [s].
        PPaaSError
            The error that the service raised.
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
