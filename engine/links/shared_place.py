"""Place as its clients share it: who they are, what they hear, the types of what there is, and their open calls.

A place is in the process of its container, next to the clone (`engine.sessions.place.place`), or at the other end of
the robot link (`engine.links.place_link`).
"""

import itertools
import logging
from abc import ABC, abstractmethod
from collections import defaultdict, deque
from collections.abc import Callable, Iterable
from functools import partial
from typing import Protocol

import msgspec

from engine.links.open_calls import Done, OpenCalls, answer_of
from engine.protocols.robot_link import NodeInfo, ServiceInfo, TopicInfo
from ppaas.errors import Conflict, PPaaSError, QuotaExceeded
from ppaas.listener_faults import ListenerFaults
from ppaas.nodes import topics
from ppaas.wire.stamped_twists import may_be_named

logger = logging.getLogger(__name__)

MAX_UNACKNOWLEDGED = 1000
MAX_UNACKNOWLEDGED_BYTES = 64 << 20
"""Largest number and total size [bytes] of the unacknowledged messages of one place."""


class Listener(Protocol):
    """Client of a place. None of its methods may block; an exception of one is logged, and concerns it alone."""

    def published(self, topic: str, payload: bytes) -> None:
        """Receive a message of a subscribed topic, as JSON."""
        ...

    def refused(self, topic: str, error: PPaaSError, sequence: int) -> None:
        """Handle the refusal of a message of this client; ``sequence`` is the number that ``deliver`` returned."""
        ...

    def acknowledged(self, sequence: int) -> None:
        """Handle that a checkpoint has all messages up to a number that ``deliver`` returned."""
        ...

    def closed(self, reason: PPaaSError) -> None:
        """Handle the end of the place."""
        ...


class Unacknowledged:
    """Numbers and sizes of the messages that must arrive and are in no checkpoint of the clone yet."""

    def __init__(self) -> None:
        self.last = 0
        """Number of the last message; 0 before the first."""
        self._sizes: deque[tuple[int, int]] = deque()
        self._bytes = 0

    def add(self, size: int) -> int:
        """Count a message of a size [bytes], and return its number.

        Raises
        ------
        QuotaExceeded
            Too many messages are unacknowledged: the client must slow down.
        """
        if len(self._sizes) >= MAX_UNACKNOWLEDGED or self._bytes + size > MAX_UNACKNOWLEDGED_BYTES:
            raise QuotaExceeded(f"{len(self._sizes)} messages are not acknowledged yet; wait before sending more")
        self.last += 1
        self._sizes.append((self.last, size))
        self._bytes += size
        return self.last

    def acknowledge(self, sequence: int) -> None:
        """Forget all messages up to a number."""
        while self._sizes and self._sizes[0][0] <= sequence:
            self._bytes -= self._sizes.popleft()[1]


def check_type(topic: str, has: str, wanted: str) -> None:
    """Raise ``Conflict`` unless a topic has the type that a client expects."""
    if has != wanted:
        raise Conflict(f"topic {topic!r} has type {has}, not {wanted}")


class SharedPlace(ABC):
    """Clients of a place with their subscriptions and calls.

    Attributes
    ----------
    topics, services, nodes : dict
        What the clone has, by name.
    """

    def __init__(self) -> None:
        self.topics: dict[str, TopicInfo] = {}
        self.services: dict[str, ServiceInfo] = {}
        self.nodes: dict[str, NodeInfo] = {}
        self._unacknowledged = Unacknowledged()
        self._calls = OpenCalls()
        self._clients: dict[int, Listener] = {}
        self._client_numbers = itertools.count(1)
        self._hearers: defaultdict[str, set[int]] = defaultdict(set)
        self._faults = ListenerFaults(logger)

    # -- to the clone --------------------------------------------------------------------------------------------------

    @abstractmethod
    def deliver(self, topic: str, payload: bytes, client: int, *, must_arrive: bool) -> int:
        """Send a message to the clone; return its sequence number, or 0 if it need not arrive.

        Raises
        ------
        QuotaExceeded
            Too many messages are unacknowledged: the client must slow down.
        """

    @abstractmethod
    def _listen(self, topic: str, client: int) -> None:
        """Request the messages of a topic, and the latched one for this client."""

    @abstractmethod
    def _ignore(self, topic: str) -> None:
        """Request the messages of a topic no longer."""

    @abstractmethod
    def _ask(self, number: int, service: str, payload: bytes) -> None:
        """Pass an open call on; raises ``Unavailable`` if there is no container."""

    # -- from the clone ------------------------------------------------------------------------------------------------

    def _topic_added(self, topic: TopicInfo, node: str) -> None:
        self.topics[topic.name] = topic
        self._publishes(node, lambda names: (*names, topic.name))

    def _topic_removed(self, topic: str) -> None:
        self.topics.pop(topic, None)
        for node in self.nodes:
            self._publishes(node, lambda names: tuple(name for name in names if name != topic))

    def _publishes(self, node: str, change: Callable[[tuple[str, ...]], tuple[str, ...]]) -> None:
        info = self.nodes[node]
        self.nodes[node] = msgspec.structs.replace(info, publishes=change(info.publishes))

    def _nodes_changed(self, services: Iterable[ServiceInfo], nodes: Iterable[NodeInfo]) -> None:
        self.services = {service.name: service for service in services}
        self.nodes = {node.name: node for node in nodes}

    def _published(self, topic: str, payload: bytes, client: int = 0) -> None:
        """Pass a message to all that hear its topic, or a latched one to the client that has just subscribed."""
        hearers = {client} if client else self._hearers.get(topic, set())
        self._notify(hearers, lambda listener: listener.published(topic, payload))

    def _map_replaced(self) -> None:
        """Request the map again for clients that do not take its changes."""
        changes = self._hearers.get(topics.MAP_UPDATES.name, set())
        for client in self._hearers.get(topics.MAP.name, set()) - changes:
            self._listen(topics.MAP.name, client)

    def _refused(self, client: int, topic: str, error: PPaaSError, sequence: int) -> None:
        self._notify((client,), lambda listener: listener.refused(topic, error, sequence))

    def _acknowledged(self, sequence: int) -> None:
        self._unacknowledged.acknowledge(sequence)
        self._notify(self._clients, lambda listener: listener.acknowledged(sequence))

    def _notify(self, clients: Iterable[int], notify: Callable[[Listener], None]) -> None:
        """Call clients, each whatever becomes of the others; they may leave meanwhile."""
        for number in tuple(clients):
            listener = self._clients.get(number)
            if listener is not None:
                self._faults.call(f"client {number}", notify, listener)

    # -- clients -------------------------------------------------------------------------------------------------------

    def join(self, listener: Listener) -> int:
        """Add a client and return its number."""
        number = next(self._client_numbers)
        self._clients[number] = listener
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
        self._listen(topic, client)

    def unsubscribe(self, topic: str, client: int) -> None:
        """End a client's subscription to a topic."""
        hearers = self._hearers.get(topic, set())
        hearers.discard(client)
        if not hearers and self._hearers.pop(topic, None) is not None:
            self._ignore(topic)

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

    @abstractmethod
    def offered_services(self) -> dict[str, str]:
        """Return the services of clients and their types, by the names of ROS 1."""

    @abstractmethod
    def offered_actions(self) -> dict[str, str]:
        """Return the actions of clients and their types, ``package/Name``."""

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
        number = self._calls.open(service, timeout, done)
        try:
            self._ask(number, service, payload)
        except PPaaSError:
            self._calls.give_up(number)
            raise
        return partial(self._calls.give_up, number)

    async def call(self, service: str, payload: bytes, timeout: float) -> bytes:
        """Call a service like ``begin_call``, wait, and return the response as JSON.

        Raises
        ------
        Unavailable
            No container is connected, the provider was lost during the call, or it did not answer in ``timeout`` [s].
        PPaaSError
            The error that the service raised.
        """
        return await answer_of(partial(self.begin_call, service, payload, timeout))
