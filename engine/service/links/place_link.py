"""The endpoint's end of the robot link: one a place, whatever container fills it.

Clients (a robot's socket, operators' sockets, a REST call) talk to the place. When its container is lost they notice
nothing but a pause: subscriptions are made again with the next one, and what must arrive is sent again until it has
been acknowledged. Only a call under way fails, and says so.
"""

import asyncio
import itertools
import logging
from collections import defaultdict
from collections.abc import Callable
from functools import partial
from typing import Protocol

import msgspec

from engine.protocols import robot_link
from engine.protocols.framing import FrameStream
from engine.service.links.client_services import ClientServices, Provider
from engine.service.links.client_topics import ClientTopics, check_type
from engine.service.links.open_calls import Done, OpenCalls, Outcome
from engine.service.links.unacknowledged import Unacknowledged
from ppaas.errors import Conflict, NotFound, PPaaSError, Unavailable, rebuild

logger = logging.getLogger(__name__)

MAX_WAITING = 1 << 20
"""Bytes that may wait for a slow container before messages that may be lost are."""


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


class PlaceLink:
    """What the clients of one place share."""

    def __init__(self, key: str) -> None:
        self.key = key
        self.pid: int | None = None
        self.container: str | None = None
        self.beats = 0
        self.busy = False
        self.round_trip: float | None = None
        self.topics: dict[str, robot_link.TopicInfo] = {}
        self.services: dict[str, robot_link.ServiceInfo] = {}
        self.nodes: dict[str, robot_link.NodeInfo] = {}
        self._stream: FrameStream[robot_link.FromContainer] | None = None
        self._ready = asyncio.Event()
        self._closed: PPaaSError | None = None
        self._clients: dict[int, Listener] = {}
        self._client_numbers = itertools.count(1)
        self._hearers: defaultdict[str, set[int]] = defaultdict(set)
        self.client_topics = ClientTopics()
        self.client_services = ClientServices()
        self._unacknowledged = Unacknowledged()
        self._calls = OpenCalls()

    # -- the container -------------------------------------------------------------------------------------------------

    async def serve(self, hello: robot_link.Hello, stream: FrameStream[robot_link.FromContainer]) -> None:
        """Be linked to a container until it hangs up, or another takes its place."""
        if self._stream is not None:
            self._lost()
        self._stream, self.pid, self.container = stream, hello.pid, hello.container
        self.topics = {topic.name: topic for topic in hello.topics}
        self._offered(hello)
        for topic in self.topics:
            self.client_topics.drop(topic)
        self._unacknowledged.follow(hello.applied)
        self._unacknowledged.acknowledge(hello.applied)
        for topic in self._hearers:
            stream.write(robot_link.Subscribe(topic, 0))
        for deliver in self._unacknowledged:
            stream.write(self._unacknowledged.sent(deliver))
        self._ready.set()

        def take(frame: robot_link.FromContainer) -> bool:
            current = self._stream is stream
            if current:
                self._take(frame)
            return current

        try:
            await stream.each(take)
        finally:
            if self._stream is stream:
                self._lost()

    def _take(self, frame: robot_link.FromContainer) -> None:
        match frame:
            case robot_link.Published():
                self._published(frame.topic, frame.payload, frame.client)
            case robot_link.Declared():
                self.client_topics.drop(frame.topic.name)
                self.topics[frame.topic.name] = frame.topic
                self._publishes(frame.node, lambda topics: (*topics, frame.topic.name))
            case robot_link.Undeclared():
                self.topics.pop(frame.name, None)
                for node in self.nodes:
                    self._publishes(node, lambda topics: tuple(topic for topic in topics if topic != frame.name))
            case robot_link.Offers():
                self._offered(frame)
            case robot_link.Answer():
                refused = frame.refusal
                self._calls.end(frame.call, rebuild(refused.slug, refused.text) if refused else frame.payload)
            case robot_link.Ack():
                self._unacknowledged.acknowledge(frame.sequence)
            case robot_link.Beat():
                self.beats += 1
                self.busy = frame.busy
            case robot_link.Refused() if frame.client in self._clients:
                error = rebuild(frame.refusal.slug, frame.refusal.text)
                self._clients[frame.client].refused(frame.topic, error, self._unacknowledged.own(frame.sequence))

    def _offered(self, offers: robot_link.Hello | robot_link.Offers) -> None:
        self.services = {service.name: service for service in offers.services}
        self.client_services.overtaken(self.services)
        self.nodes = {node.name: node for node in offers.nodes}

    def _published(self, topic: str, payload: bytes, client: int | None = None) -> None:
        hearers = self._hearers.get(topic, set()) if client is None else {client}
        for listener in [self._clients[n] for n in hearers if n in self._clients]:
            listener.published(topic, payload)

    def _publishes(self, node: str, change: Callable[[tuple[str, ...]], tuple[str, ...]]) -> None:
        info = self.nodes[node]
        self.nodes[node] = msgspec.structs.replace(info, publishes=change(info.publishes))

    def _lost(self) -> None:
        self._stream = self.pid = self.container = None
        if self._closed is None:
            self._ready.clear()
        self._calls.fail(Unavailable("the container was lost while it worked on this; ask again"))

    def release(self) -> None:
        """Let the container keep its state and end; the place goes on with the next."""
        if self._stream is not None:
            self._stream.write(robot_link.Stop())

    def close(self, reason: PPaaSError) -> None:
        """Tell all clients that the place is no more."""
        self._closed = reason
        self._ready.set()
        if self._stream is not None:
            self._stream.write(robot_link.Stop())
        self._calls.fail(reason)
        for client in tuple(self._clients.values()):
            client.closed(reason)
        self._clients.clear()

    def note_round_trip(self, seconds: float) -> None:
        """Note how far the robot is: the round trip of a ping [s]."""
        self.round_trip = seconds

    # -- the clients ---------------------------------------------------------------------------------------------------

    async def ready(self, timeout: float) -> None:
        """Wait for a container.

        Raises
        ------
        Unavailable
            None came in time.
        PPaaSError
            The place was closed, with its reason.
        """
        if not self._ready.is_set():
            try:
                async with asyncio.timeout(timeout):
                    await self._ready.wait()
            except TimeoutError as error:
                raise Unavailable(f"no container was ready within {timeout:g} s; try again") from error
        if self._closed is not None:
            raise self._closed

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
        if self._stream is not None:
            self._stream.write(robot_link.Subscribe(topic, client))
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
        if not hearers and self._hearers.pop(topic, None) is not None and self._stream is not None:
            self._stream.write(robot_link.Unsubscribe(topic))

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

    def deliver(self, topic: str, payload: bytes, client: int, *, must_arrive: bool) -> int:
        """Bring a message to the clone; return its sequence number, or 0.

        What must not arrive is dropped while there is no container, or a slow one.

        Raises
        ------
        QuotaExceeded
            Too much waits to be acknowledged: the client must slow down.
        """
        if not must_arrive:
            if self._stream is not None and self._stream.waiting <= MAX_WAITING:
                self._stream.write(robot_link.Deliver(topic, payload, client))
            return 0
        deliver = self._unacknowledged.add(topic, payload, client)
        if self._stream is not None:
            self._stream.write(self._unacknowledged.sent(deliver))
        return deliver.sequence

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
        if self._stream is None:
            raise Unavailable("the robot has no container at this moment; try again")
        number = self._calls.open(service, timeout, done)
        self._stream.write(robot_link.Call(number, service, payload))
        return partial(self._calls.give_up, number)

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
