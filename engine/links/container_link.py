"""The endpoint's end of the robot link: one for each place, reused by all containers that fill it.

After the loss of a container, messages that must arrive are sent to the next one until they are acknowledged. Only open
calls fail, with an error.
"""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable
from functools import partial

import msgspec

from engine.links.frame_writer import FrameWriter
from engine.links.open_calls import Done, OpenCalls
from engine.links.unacknowledged import Unacknowledged
from engine.protocols import robot_link
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import error_of
from ppaas.errors import PPaaSError, Unavailable

MAX_WAITING = 1 << 20
"""Size of the send queue of a slow container [bytes] above which messages that need not arrive are dropped."""


Stream = FrameWriter[robot_link.ToContainer]
"""Stream of frames to a container."""


class ContainerLink(ABC):
    """Link to the current container of a place; passes its frames to the place's clients."""

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

    @abstractmethod
    def _wanted(self) -> Iterable[str]:
        """Return the topics that clients are subscribed to."""

    @abstractmethod
    def _published(self, topic: str, payload: bytes, client: int | None = None) -> None:
        """Pass a message to all subscribers of its topic, or to one client only."""

    @abstractmethod
    def _map_replaced(self) -> None:
        """Send the whole map to the clients that do not take its changes."""

    @abstractmethod
    def _refused(self, client: int, topic: str, error: PPaaSError, sequence: int) -> None:
        """Notify a client that its message was refused."""

    def _declared(self, topic: str) -> None:
        """Handle a new topic of the clone."""

    def _served(self, services: Collection[str]) -> None:
        """Handle the current services of the clone."""

    def _acknowledged(self, sequence: int) -> None:
        """Handle that all messages up to a sequence number are in a checkpoint."""

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
        for topic in self._wanted():
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
                self._publishes(frame.node, lambda topics: (*topics, frame.topic.name))
            case robot_link.TopicRemoved():
                self.topics.pop(frame.name, None)
                for node in self.nodes:
                    self._publishes(node, lambda topics: tuple(topic for topic in topics if topic != frame.name))
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
            self._acknowledged(self._unacknowledged.own(frame.sequence))
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
        """End the container and close the place; open calls fail with ``reason``."""
        self._closed = reason
        self._ready.set()
        self._write(robot_link.Shutdown())
        self._calls.fail(reason)

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

    def _ask(self, service: str, payload: bytes, timeout: float, done: Done) -> Callable[[], object]:
        """Call a service of the clone, with ``done`` called once with the outcome; return a function to cancel it.

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
