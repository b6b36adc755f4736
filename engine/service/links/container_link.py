"""The endpoint's end of the robot link: one a place, whatever container fills it.

When a container is lost the next one takes its place: what must arrive is sent again until it has been acknowledged.
Only a call under way fails, and says so.
"""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable
from functools import partial

import msgspec

from engine.protocols import robot_link
from engine.protocols.framing import FrameStream
from engine.service.links.open_calls import Done, OpenCalls
from engine.service.links.unacknowledged import Unacknowledged
from ppaas.errors import PPaaSError, Unavailable, rebuild

MAX_WAITING = 1 << 20
"""Bytes that may wait for a slow container before messages that may be lost are."""


class ContainerLink(ABC):
    """The link to the container that fills a place, one after the other; what it says goes to the place's clients."""

    def __init__(self) -> None:
        self.pid: int | None = None
        self.container: str | None = None
        self.beats = 0
        self.busy = False
        self.topics: dict[str, robot_link.TopicInfo] = {}
        self.services: dict[str, robot_link.ServiceInfo] = {}
        self.nodes: dict[str, robot_link.NodeInfo] = {}
        self._stream: FrameStream[robot_link.FromContainer] | None = None
        self._ready = asyncio.Event()
        self._closed: PPaaSError | None = None
        self._unacknowledged = Unacknowledged()
        self._calls = OpenCalls()

    @abstractmethod
    def _wanted(self) -> Iterable[str]:
        """Return the topics that some client hears."""

    @abstractmethod
    def _published(self, topic: str, payload: bytes, client: int | None = None) -> None:
        """Give a message to those who hear its topic, or to one client alone."""

    @abstractmethod
    def _refused(self, client: int, topic: str, error: PPaaSError, sequence: int) -> None:
        """Tell a client that its message was not taken."""

    @abstractmethod
    def _declared(self, topic: str) -> None:
        """Note that the clone itself has a topic from now on."""

    @abstractmethod
    def _served(self, services: Collection[str]) -> None:
        """Note which services the clone itself answers from now on."""

    async def serve(self, hello: robot_link.Hello, stream: FrameStream[robot_link.FromContainer]) -> None:
        """Be linked to a container until it hangs up, or another takes its place."""
        if self._stream is not None:
            self._lost()
        self._stream, self.pid, self.container = stream, hello.pid, hello.container
        self.topics = {topic.name: topic for topic in hello.topics}
        self._offered(hello)
        for topic in self.topics:
            self._declared(topic)
        self._unacknowledged.follow(hello.applied)
        self._unacknowledged.acknowledge(hello.applied)
        for topic in self._wanted():
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
            case robot_link.TopicAdded():
                self._declared(frame.topic.name)
                self.topics[frame.topic.name] = frame.topic
                self._publishes(frame.node, lambda topics: (*topics, frame.topic.name))
            case robot_link.TopicRemoved():
                self.topics.pop(frame.name, None)
                for node in self.nodes:
                    self._publishes(node, lambda topics: tuple(topic for topic in topics if topic != frame.name))
            case robot_link.NodesChanged():
                self._offered(frame)
            case robot_link.ServiceAnswer():
                refused = frame.refusal
                self._calls.end(frame.call, rebuild(refused.slug, refused.text) if refused else frame.payload)
            case robot_link.Ack():
                self._unacknowledged.acknowledge(frame.sequence)
            case robot_link.ContainerBeat():
                self.beats += 1
                self.busy = frame.busy
            case robot_link.MessageRefused():
                error = rebuild(frame.refusal.slug, frame.refusal.text)
                self._refused(frame.client, frame.topic, error, self._unacknowledged.own(frame.sequence))

    def _offered(self, offers: robot_link.Hello | robot_link.NodesChanged) -> None:
        self.services = {service.name: service for service in offers.services}
        self._served(self.services)
        self.nodes = {node.name: node for node in offers.nodes}

    def _publishes(self, node: str, change: Callable[[tuple[str, ...]], tuple[str, ...]]) -> None:
        info = self.nodes[node]
        self.nodes[node] = msgspec.structs.replace(info, publishes=change(info.publishes))

    def _lost(self) -> None:
        self._stream = self.pid = self.container = None
        if self._closed is None:
            self._ready.clear()
        self._calls.fail(Unavailable("the container was lost while it worked on this; ask again"))

    def _write(self, frame: robot_link.ToContainer) -> None:
        """Send to the container, if there is one now."""
        if self._stream is not None:
            self._stream.write(frame)

    def release(self) -> None:
        """Let the container keep its state and end; the place goes on with the next."""
        self._write(robot_link.Shutdown())

    def close(self, reason: PPaaSError) -> None:
        """Let the container end: the place is no more."""
        self._closed = reason
        self._ready.set()
        self._write(robot_link.Shutdown())
        self._calls.fail(reason)

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
        self._write(self._unacknowledged.sent(deliver))
        return deliver.sequence

    def _ask(self, service: str, payload: bytes, timeout: float, done: Done) -> Callable[[], object]:
        """Call a service of the clone; ``done`` gets the outcome, once. Return what gives the call up.

        Raises
        ------
        Unavailable
            There is no container.
        """
        if self._stream is None:
            raise Unavailable("the robot has no container at this moment; try again")
        number = self._calls.open(service, timeout, done)
        self._stream.write(robot_link.ServiceCall(number, service, payload))
        return partial(self._calls.give_up, number)
