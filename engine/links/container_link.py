"""Container link: the place's end of the robot link, shared by the clients of one process.

Clients use the link, not a container. When its container is lost, they notice only a pause: subscriptions are repeated
with the next container, and messages that must arrive are sent again until they are acknowledged. Only open calls fail,
with an error.
"""

import asyncio
import itertools
import logging
from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable
from functools import partial
from typing import Protocol

import msgspec

from engine.links.frame_writer import FrameWriter
from engine.links.open_calls import Done, OpenCalls, answer_of
from engine.links.topic_types import check_type
from engine.links.unacknowledged import Unacknowledged
from engine.protocols import robot_link
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import error_of
from ppaas.errors import PPaaSError, Unavailable
from ppaas.listener_faults import ListenerFaults
from ppaas.nodes import topics
from ppaas.wire.stamped_twists import may_be_named

logger = logging.getLogger(__name__)

MAX_WAITING = 1 << 20
"""Size of the send queue of a slow container [bytes] above which messages that need not arrive are dropped."""


Stream = FrameWriter[robot_link.ToContainer]
"""Stream of frames to a container."""


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


class ContainerLink(ABC):
    """Link to the current container of a place, with the clients, their subscriptions, messages and calls."""

    def __init__(self) -> None:
        self.pid: int | None = None
        self.container: str | None = None
        self.beats = 0
        self.busy = False
        self.beat = robot_link.ContainerBeat(busy=False)
        self.topics: dict[str, robot_link.TopicInfo] = {}
        self.services: dict[str, robot_link.ServiceInfo] = {}
        self.nodes: dict[str, robot_link.NodeInfo] = {}
        self._stream: Stream | None = None
        self._ready = asyncio.Event()
        self._closed: PPaaSError | None = None
        self._unacknowledged = Unacknowledged()
        self._calls = OpenCalls()
        self._clients: dict[int, Listener] = {}
        self._client_numbers = itertools.count(1)
        self._hearers: defaultdict[str, set[int]] = defaultdict(set)
        self._faults = ListenerFaults(logger)

    def _declared(self, topic: str) -> None:
        """Handle a new topic of the clone."""

    def _served(self, services: Collection[str]) -> None:
        """Handle the current services of the clone."""

    # -- the container -------------------------------------------------------------------------------------------------

    async def serve(self, hello: robot_link.Hello, stream: FrameStream[robot_link.FromContainer]) -> None:
        """Serve a container until it disconnects or is replaced by another."""
        self.begin(hello, stream)

        def take(frame: robot_link.FromContainer) -> bool:
            current = self._stream is stream
            if current:
                self.take(frame)
            return current

        try:
            await stream.each(take)
        finally:
            if self._stream is stream:
                self._lost()

    def begin(self, hello: robot_link.Hello, stream: Stream) -> None:
        """Begin to serve a container, which may replace another: repeat subscriptions and unacknowledged messages."""
        if self._stream is not None:
            self._lost()
        self._stream, self.pid, self.container = stream, hello.pid, hello.container
        self.busy, self.beat = hello.beat.busy, hello.beat
        self.topics = {topic.name: topic for topic in hello.topics}
        self._offered(hello)
        for topic in self.topics:
            self._declared(topic)
        self._unacknowledged.follow(hello.applied)
        self._unacknowledged.acknowledge(hello.applied)
        for topic in self._hearers:
            stream.write(robot_link.Subscribe(topic, 0))
        for deliver in self._unacknowledged:
            stream.write(self._unacknowledged.sent(deliver))
        self._ready.set()

    def take(self, frame: robot_link.FromContainer) -> None:
        """Handle a frame of the container."""
        match frame:
            case robot_link.Published():
                self._published(frame.topic, frame.payload, frame.client)
            case robot_link.MapReplaced():
                self._map_replaced()
            case robot_link.TopicAdded():
                self._declared(frame.topic.name)
                self.topics[frame.topic.name] = frame.topic
                self._publishes(frame.node, lambda names: (*names, frame.topic.name))
            case robot_link.TopicRemoved():
                self.topics.pop(frame.name, None)
                for node in self.nodes:
                    self._publishes(node, lambda names: tuple(name for name in names if name != frame.name))
            case robot_link.NodesChanged():
                self._offered(frame)
            case robot_link.ServiceAnswer():
                refused = frame.refusal
                self._calls.end(frame.call, error_of(refused) if refused else frame.payload)
            case robot_link.Ack() | robot_link.ContainerBeat():
                self._note(frame)
            case robot_link.MessageRefused():
                error = error_of(frame.refusal)
                self._refused(frame.client, frame.topic, error, self._unacknowledged.own(frame.sequence))

    def _note(self, frame: robot_link.Ack | robot_link.ContainerBeat) -> None:
        if isinstance(frame, robot_link.Ack):
            self._unacknowledged.acknowledge(frame.sequence)
            sequence = self._unacknowledged.own(frame.sequence)
            self._tell(self._clients, lambda listener: listener.acknowledged(sequence))
        else:
            self.beats += 1
            self.busy, self.beat = frame.busy, frame

    def _offered(self, offers: robot_link.Hello | robot_link.NodesChanged) -> None:
        self.services = {service.name: service for service in offers.services}
        self._served(self.services)
        self.nodes = {node.name: node for node in offers.nodes}

    def _publishes(self, node: str, change: Callable[[tuple[str, ...]], tuple[str, ...]]) -> None:
        info = self.nodes[node]
        self.nodes[node] = msgspec.structs.replace(info, publishes=change(info.publishes))

    def _tell(self, clients: Iterable[int], tell: Callable[[Listener], None]) -> None:
        """Call clients, each whatever becomes of the others; they may leave meanwhile."""
        for number in tuple(clients):
            listener = self._clients.get(number)
            if listener is not None:
                self._faults.call(f"client {number}", tell, listener)

    def _published(self, topic: str, payload: bytes, client: int | None = None) -> None:
        hearers = self._hearers.get(topic, set()) if client is None else {client}
        self._tell(hearers, lambda listener: listener.published(topic, payload))

    def _map_replaced(self) -> None:
        changes = self._hearers.get(topics.MAP_UPDATES.name, set())
        for client in self._hearers.get(topics.MAP.name, set()) - changes:
            self._write(robot_link.Subscribe(topics.MAP.name, client))

    def _refused(self, client: int, topic: str, error: PPaaSError, sequence: int) -> None:
        self._tell((client,), lambda listener: listener.refused(topic, error, sequence))

    def _lost(self) -> None:
        self._stream = self.pid = self.container = None
        if self._closed is None:
            self._ready.clear()
        self._calls.fail(Unavailable("the container was lost before it answered; call again"))

    def _write(self, frame: robot_link.ToContainer) -> None:
        """Send a frame to the container, if one is connected."""
        if self._stream is not None:
            self._stream.write(frame)

    def release(self) -> None:
        """Make the container store its state and end; the place stays open for the next one."""
        self._write(robot_link.Shutdown())

    def close(self, reason: PPaaSError) -> None:
        """End the container and close the place: open calls fail with ``reason``, and all clients are notified."""
        self._closed = reason
        self._ready.set()
        self._write(robot_link.Shutdown())
        self._calls.fail(reason)
        self._tell(self._clients, lambda listener: listener.closed(reason))
        self._clients.clear()

    @property
    def closed(self) -> PPaaSError | None:
        """Reason for which the place was closed; None while it is open."""
        return self._closed

    async def ready(self, timeout: float, why: Callable[[], PPaaSError | None] = lambda: None) -> None:
        """Wait for a container.

        Parameters
        ----------
        timeout : float
            Time limit [s].
        why : callable
            Returns the reason why no container is ready in time, if it is known.

        Raises
        ------
        Unavailable
            No container connected in time.
        PPaaSError
            The place was closed; the reason for it.
        """
        if not self._ready.is_set():
            try:
                async with asyncio.timeout(timeout):
                    await self._ready.wait()
            except TimeoutError as error:
                raise why() or Unavailable(f"no container was ready within {timeout:g} s; try again") from error
        if self._closed is not None:
            raise self._closed

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

    def deliver(self, topic: str, payload: bytes, client: int, *, must_arrive: bool) -> int:
        """Send a message to the clone; return its sequence number, or 0 if it need not arrive.

        A message that need not arrive is dropped while no container is connected, or a slow one.

        Raises
        ------
        QuotaExceeded
            Too many messages are unacknowledged: the client must slow down.
        """
        if not must_arrive:
            if self._stream is not None and self._stream.waiting <= MAX_WAITING:
                self._stream.write(robot_link.Deliver(topic, payload, client))
            return 0
        deliver = self._unacknowledged.add(topic, payload, client)
        self._write(self._unacknowledged.sent(deliver))
        return deliver.sequence

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
        if self._stream is None:
            raise Unavailable("the robot has no container at the moment; try again")
        number = self._calls.open(service, timeout, done)
        self._stream.write(robot_link.ServiceCall(number, service, payload))
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
