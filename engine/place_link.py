"""The endpoint's end of the robot link: one a place, whatever container fills it.

Clients (a robot's socket, operators' sockets, a REST call) talk to the place. When its container is lost they notice
nothing but a pause: subscriptions are made again with the next one, and what must arrive is sent again until it has
been acknowledged. Only a call under way fails, and says so.
"""

import asyncio
import itertools
import logging
from collections import defaultdict, deque
from collections.abc import Callable
from typing import Protocol

import msgspec

from engine import link
from engine.framing import FrameStream
from ppaas.errors import NotFound, PPaaSError, QuotaExceeded, Unavailable, rebuild

logger = logging.getLogger(__name__)

MAX_UNACKNOWLEDGED = 1000
MAX_UNACKNOWLEDGED_BYTES = 64 << 20
"""Messages, and bytes of messages, of one place that are kept until the clone has acknowledged them."""

MAX_WAITING = 1 << 20
"""Bytes that may wait for a slow container before messages that may be lost are."""


class Listener(Protocol):
    """A client, as a place sees it. None of these may block."""

    def published(self, topic: str, payload: bytes) -> None:
        """Take a message of a topic that the client subscribed to, as JSON."""
        ...

    def refused(self, topic: str, error: PPaaSError) -> None:
        """Learn that the clone did not take a message of this client."""
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
        self.topics: dict[str, link.TopicInfo] = {}
        self.services: dict[str, link.ServiceInfo] = {}
        self.nodes: dict[str, link.NodeInfo] = {}
        self._stream: FrameStream[link.FromContainer] | None = None
        self._ready = asyncio.Event()
        self._closed: PPaaSError | None = None
        self._clients: dict[int, Listener] = {}
        self._client_numbers = itertools.count(1)
        self._hearers: defaultdict[str, set[int]] = defaultdict(set)
        self._sequences = itertools.count(1)
        self._unacknowledged: deque[link.Deliver] = deque()
        self._unacknowledged_bytes = 0
        self._call_numbers = itertools.count(1)
        self._calls: dict[int, asyncio.Future[bytes]] = {}

    # -- the container -------------------------------------------------------------------------------------------------

    async def serve(self, hello: link.Hello, stream: FrameStream[link.FromContainer]) -> None:
        """Be linked to a container until it hangs up, or another takes its place."""
        if self._stream is not None:
            self._lost()
        self._stream, self.pid, self.container = stream, hello.pid, hello.container
        self.topics = {topic.name: topic for topic in hello.topics}
        self.services = {service.name: service for service in hello.services}
        self.nodes = {node.name: node for node in hello.nodes}
        self._acknowledge(hello.applied)
        for topic in self._hearers:
            stream.write(link.Subscribe(topic, 0))
        for deliver in self._unacknowledged:
            stream.write(deliver)
        self._ready.set()
        try:
            while (frame := await stream.receive()) is not None and self._stream is stream:
                self._take(frame)
        finally:
            if self._stream is stream:
                self._lost()

    def _take(self, frame: link.FromContainer) -> None:
        match frame:
            case link.Published():
                hearers = self._hearers.get(frame.topic, set()) if frame.client is None else {frame.client}
                for client in [self._clients[n] for n in hearers if n in self._clients]:
                    client.published(frame.topic, frame.payload)
            case link.Declared():
                self.topics[frame.topic.name] = frame.topic
                self._publishes(frame.node, lambda topics: (*topics, frame.topic.name))
            case link.Undeclared():
                self.topics.pop(frame.name, None)
                for node in self.nodes:
                    self._publishes(node, lambda topics: tuple(topic for topic in topics if topic != frame.name))
            case link.Answer():
                self._answered(frame)
            case link.Ack():
                self._acknowledge(frame.sequence)
            case link.Refused() if frame.client in self._clients:
                self._clients[frame.client].refused(frame.topic, rebuild(frame.refusal.slug, frame.refusal.text))

    def _publishes(self, node: str, change: Callable[[tuple[str, ...]], tuple[str, ...]]) -> None:
        info = self.nodes[node]
        self.nodes[node] = msgspec.structs.replace(info, publishes=change(info.publishes))

    def _answered(self, answer: link.Answer) -> None:
        future = self._calls.pop(answer.call, None)
        if future is None or future.done():
            return
        if answer.refusal is None:
            future.set_result(answer.payload)
        else:
            future.set_exception(rebuild(answer.refusal.slug, answer.refusal.text))

    def _acknowledge(self, sequence: int) -> None:
        while self._unacknowledged and self._unacknowledged[0].sequence <= sequence:
            self._unacknowledged_bytes -= len(self._unacknowledged.popleft().payload)

    def _lost(self) -> None:
        self._stream = self.pid = self.container = None
        if self._closed is None:
            self._ready.clear()
        self._fail_calls(Unavailable("the container was lost while it worked on this; ask again"))

    def _fail_calls(self, reason: PPaaSError) -> None:
        for future in self._calls.values():
            if not future.done():
                future.set_exception(reason)
        self._calls.clear()

    def close(self, reason: PPaaSError) -> None:
        """Tell all clients that the place is no more."""
        self._closed = reason
        self._ready.set()
        if self._stream is not None:
            self._stream.write(link.Stop())
        self._fail_calls(reason)
        for client in tuple(self._clients.values()):
            client.closed(reason)
        self._clients.clear()

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
        """Forget a client and its subscriptions."""
        self._clients.pop(client, None)
        for topic in tuple(self._hearers):
            self.unsubscribe(topic, client)

    def subscribe(self, topic: str, client: int) -> None:
        """Let a client hear a topic.

        Raises
        ------
        NotFound
            The clone has no such topic. (Known once a container was ready.)
        """
        if self.topics and topic not in self.topics:
            raise NotFound("topic", topic, list(self.topics))
        self._hearers[topic].add(client)
        if self._stream is not None:
            self._stream.write(link.Subscribe(topic, client))

    def unsubscribe(self, topic: str, client: int) -> None:
        """Let a client hear a topic no more."""
        hearers = self._hearers.get(topic, set())
        hearers.discard(client)
        if not hearers and self._hearers.pop(topic, None) is not None and self._stream is not None:
            self._stream.write(link.Unsubscribe(topic))

    def deliver(self, topic: str, payload: bytes, client: int, *, must_arrive: bool) -> None:
        """Bring a message to the clone; what must not arrive is dropped while there is no container, or a slow one.

        Raises
        ------
        QuotaExceeded
            Too much waits to be acknowledged: the client must slow down.
        """
        if not must_arrive:
            if self._stream is not None and self._stream.waiting <= MAX_WAITING:
                self._stream.write(link.Deliver(topic, payload, client))
            return
        size = self._unacknowledged_bytes + len(payload)
        if len(self._unacknowledged) >= MAX_UNACKNOWLEDGED or size > MAX_UNACKNOWLEDGED_BYTES:
            count = len(self._unacknowledged)
            raise QuotaExceeded(f"{count} messages wait to be acknowledged; wait before sending more")
        self._unacknowledged_bytes = size
        deliver = link.Deliver(topic, payload, client, next(self._sequences))
        self._unacknowledged.append(deliver)
        if self._stream is not None:
            self._stream.write(deliver)

    async def call(self, service: str, payload: bytes, timeout: float) -> bytes:
        """Call a service of the clone; return the response as JSON.

        Raises
        ------
        Unavailable
            There is no container, it was lost meanwhile, or it did not answer in time.
        PPaaSError
            What the service raised.
        """
        if self._stream is None:
            raise Unavailable("the robot has no container at this moment; try again")
        number = next(self._call_numbers)
        future: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()
        self._calls[number] = future
        self._stream.write(link.Call(number, service, payload))
        try:
            async with asyncio.timeout(timeout):
                return await future
        except TimeoutError as error:
            raise Unavailable(f"service {service!r} did not answer within {timeout:g} s") from error
        finally:
            self._calls.pop(number, None)
