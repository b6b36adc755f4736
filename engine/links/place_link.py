"""Place link: the endpoint's end of the robot link, which carries the sockets of a robot and its operators.

Endpoints call services of the clone by it, and subscribe to its topics themselves. The sessions of clients are in the
container (`engine.sessions`).

Clients use the place, not a container. When its container is lost, they notice only a pause: subscriptions are repeated
with the next container, and messages that must arrive are sent again until they are acknowledged. Only open calls fail,
with an error.
"""

import asyncio
import itertools
from collections import deque
from collections.abc import Callable
from typing import ParamSpec

import msgspec

from engine.links.carried_session import CarriedSession
from engine.links.frame_writer import FrameWriter
from engine.links.shared_place import Listener, SharedPlace
from engine.protocols import robot_link, session_frames
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import error_of
from engine.protocols.session_frames import ClientOffers
from ppaas.errors import PPaaSError, Unavailable
from ppaas.nodes.frames import BASE_LINK
from ppaas.tracing.spans import traceparent

P = ParamSpec("P")

MAX_WAITING = 1 << 20
"""Size of the send queue of a slow container [bytes] above which messages that need not arrive are dropped."""

Stream = FrameWriter[robot_link.ToContainer]
"""Stream of frames to a container."""

EndpointOrder = Callable[[int], robot_link.DialEndpoint]
"""Returns the order to dial an endpoint for a container, given its number among those of the place."""


class PlaceLink(SharedPlace):
    """A place, as an endpoint sees it.

    Parameters
    ----------
    key : str
        Name of the place.
    base_frame : str
        Frame in which the robot is driven.

    Attributes
    ----------
    offers : ClientOffers
        What the clients of the place offer, as the container told last.
    generation : int
        Number of the latest container that has dialled this endpoint; 0 in the process of the master.
    nearer : str
        Address of an endpoint on the container's machine, if this one is on another; empty for none.
    pid, container : optional
        Process and id of the container; None while there is none.
    beat : ContainerBeat
        Its last heartbeat.
    beats : int
        Number of heartbeats.
    stops : StopsInForce, optional
        Stops that hold its robot, as the container reported last; None while there is no container, or no robot.
    stops_reported : callable
        Called after each report of them.
    """

    def __init__(self, key: str, base_frame: str = BASE_LINK) -> None:
        super().__init__()
        self.key = key
        self.base_frame = base_frame
        self.offers = ClientOffers({}, {}, {}, [])
        self._carried: dict[int, CarriedSession] = {}
        self._endpoints: dict[str, EndpointOrder] = {}
        self.generation = 0
        self.nearer = ""
        self._numbers = itertools.count(1)
        self._count = 0
        self.pid: int | None = None
        self.container: str | None = None
        self.beats = 0
        self.busy = False
        self.beat = robot_link.ContainerBeat(busy=False)
        self.stops: robot_link.StopsInForce | None = None
        self.stops_reported: Callable[[], None] = lambda: None
        self._stream: Stream | None = None
        self._ready = asyncio.Event()
        self._closed: PPaaSError | None = None
        # Messages are numbered from 1 here. An earlier cloud process may have served the first container of the place,
        # so numbers on the link continue from the last one that this container has applied.
        self._kept: deque[robot_link.Deliver] = deque()
        self._before: int | None = None

    # -- the container -------------------------------------------------------------------------------------------------

    async def serve(self, hello: robot_link.Hello, stream: FrameStream[robot_link.FromContainer]) -> None:
        """Serve a container until it disconnects or is replaced by another."""
        self.begin(hello, stream)

        def take(frame: robot_link.FromContainer) -> bool:
            current = self._stream is stream  # frames of a container that was replaced are old news
            if current:
                self.take(frame)
            return current

        try:
            await stream.each(take)
        finally:
            if self._stream is stream:
                self._lost()

    def begin(self, hello: robot_link.Hello, stream: Stream) -> None:
        """Begin to serve a container, which may replace another.

        Subscriptions and unacknowledged messages are repeated, the sockets are attached there, and it gets the order to
        dial the endpoints of the place.
        """
        if self._stream is not None:
            self._lost()
        self._stream, self.pid, self.container = stream, hello.pid, hello.container
        self.busy, self.beat = hello.beat.busy, hello.beat
        self.topics = {topic.name: topic for topic in hello.topics}
        self._nodes_changed(hello.services, hello.nodes)
        self._repeat(hello.applied, stream)
        self._ready.set()
        self._count += 1
        for order in self._endpoints.values():  # with the number of this container: endpoints serve no earlier one
            self.send(order(self._count))
        for session in tuple(self._carried.values()):
            self._guard(session, session.attach)
        self._note_stops(hello.stops)

    def _note_stops(self, stops: robot_link.StopsInForce | None) -> None:
        self.stops = stops
        self.stops_reported()

    def _repeat(self, applied: int, stream: Stream) -> None:
        if self._before is None:
            self._before = applied
        self._forget(self._own(applied))
        for topic in self._hearers:
            stream.write(robot_link.SubscribeTopic(topic, 0))
        for deliver in self._kept:
            stream.write(self._numbered(deliver))

    def _numbered(self, deliver: robot_link.Deliver) -> robot_link.Deliver:
        if not self._before:
            return deliver
        return msgspec.structs.replace(deliver, sequence=deliver.sequence + self._before)

    def _own(self, sequence: int) -> int:
        """Convert a number on the link to the number here; 0 stays 0."""
        return sequence - (self._before or 0) if sequence else 0

    def _forget(self, sequence: int) -> None:
        self._unacknowledged.acknowledge(sequence)
        while self._kept and self._kept[0].sequence <= sequence:
            self._kept.popleft()

    def _lost(self) -> None:
        self._stream = self.pid = self.container = self.stops = None
        if self._closed is None:  # those who wait for a closed place are to get the reason
            self._ready.clear()
        self._calls.fail(Unavailable("the container was lost before it answered; call again"))

    def take(self, frame: robot_link.FromContainer) -> None:
        """Handle a frame of the container."""
        match frame:
            case session_frames.SocketFrame():
                session = self._carried.get(frame.socket)
                if session is not None:
                    self._guard(session, session.deliver, frame)
            case (
                session_frames.Attached()
                | session_frames.Settled()
                | session_frames.SessionOver()
                | session_frames.CountPlan()
            ):
                session = self._carried.get(frame.socket)
                if session is not None:
                    self._guard(session, session.note, frame)
            case ClientOffers():
                self.offers = frame
            case robot_link.StopsInForce():
                self._note_stops(frame)
            case _:
                self._take_of_clone(frame)

    def _take_of_clone(self, frame: robot_link.FromContainer) -> None:
        match frame:
            case robot_link.Published():
                self._published(frame.topic, frame.payload, frame.client or 0)
            case robot_link.MapReplaced():
                self._map_replaced()
            case robot_link.TopicAdded():
                self._topic_added(frame.topic, frame.node)
            case robot_link.TopicRemoved():
                self._topic_removed(frame.name)
            case robot_link.NodesChanged():
                self._nodes_changed(frame.services, frame.nodes)
            case robot_link.ServiceAnswer():
                refused = frame.refusal
                self._calls.end(frame.call, error_of(refused) if refused else frame.payload)
            case robot_link.Ack():
                sequence = self._own(frame.sequence)
                self._forget(sequence)
                self._acknowledged(sequence)
            case robot_link.ContainerBeat():
                self.beats += 1
                self.busy, self.beat = frame.busy, frame
            case robot_link.MessageRefused():
                self._refused(frame.client, frame.topic, error_of(frame.refusal), self._own(frame.sequence))

    def release(self) -> None:
        """Make the container store its state and end; the place stays open for the next one."""
        self.send(robot_link.Shutdown())

    def close(self, reason: PPaaSError) -> None:
        """End the container and close the place: open calls fail with ``reason``, and all clients are notified."""
        self._closed = reason
        self._ready.set()
        self.send(robot_link.Shutdown())
        self._calls.fail(reason)
        self._notify(self._clients, lambda listener: listener.closed(reason))
        self._clients.clear()
        for session in tuple(self._carried.values()):
            session.closed(reason)

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

    def _guard(self, session: CarriedSession, work: Callable[P, None], *args: P.args, **kwargs: P.kwargs) -> None:
        """Let a session do work; one that fails ends, and the others go on."""
        fault = self._faults.call(f"a session of {self.key}", work, *args, **kwargs)
        if fault is not None:
            session.closed(fault)

    # -- to the clone --------------------------------------------------------------------------------------------------

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
                self._stream.write(robot_link.Deliver(topic, payload, client, trace=traceparent()))
            return 0
        deliver = robot_link.Deliver(topic, payload, client, self._unacknowledged.add(len(payload)), traceparent())
        self._kept.append(deliver)
        self.send(self._numbered(deliver))
        return deliver.sequence

    def _listen(self, topic: str, client: int) -> None:
        self.send(robot_link.SubscribeTopic(topic, client))

    def _ignore(self, topic: str) -> None:
        self.send(robot_link.UnsubscribeTopic(topic))

    def _ask(self, number: int, service: str, payload: bytes) -> None:
        if not self.send(robot_link.ServiceCall(number, service, payload, traceparent())):
            raise Unavailable("the robot has no container at the moment; try again")

    def send(self, frame: robot_link.ToContainer) -> bool:
        """Send a frame to the container; return whether there is one."""
        if self._stream is None:
            return False
        self._stream.write(frame)
        return True

    # -- clients -------------------------------------------------------------------------------------------------------

    def join(self, listener: Listener) -> int:
        """Add a client and return its number. If the place is closed already, the client is notified at once."""
        number = super().join(listener)
        if self._closed is not None:
            del self._clients[number]
            listener.closed(self._closed)
        return number

    # -- endpoints -----------------------------------------------------------------------------------------------------

    def add_endpoint(self, name: str, order: EndpointOrder) -> None:
        """Let the containers of the place dial an endpoint; ``order`` is called for each with its number."""
        if name not in self._endpoints:
            self._endpoints[name] = order
            self.send(order(self._count))

    def drop_endpoint(self, endpoint: str) -> None:
        """Let the containers of the place leave an endpoint."""
        if self._endpoints.pop(endpoint, None) is not None:
            self.send(robot_link.LeaveEndpoint(endpoint))

    # -- sockets -------------------------------------------------------------------------------------------------------

    def carry(self, session: CarriedSession) -> int:
        """Begin to carry the frames of a session; return the number of its socket."""
        number = next(self._numbers)
        self._carried[number] = session
        if self._closed is not None:
            session.closed(self._closed)
        return number

    def drop(self, socket: int) -> None:
        """Carry the frames of a session no longer."""
        self._carried.pop(socket, None)

    @property
    def waiting(self) -> int:
        """Number of bytes that wait for a slow container."""
        return 0 if self._stream is None else self._stream.waiting

    @property
    def clients(self) -> int:
        """Number of clients: sockets at all endpoints, and those within this process."""
        return super().clients + max(len(self._carried), self.beat.sockets)

    @property
    def has_clients(self) -> bool:
        """True if this process has clients of the place."""
        return bool(self._carried) or super().clients > 0

    def note_round_trip(self, seconds: float) -> None:
        """Report the round trip of a ping to the robot [s] to the container."""
        self.send(session_frames.RoundTrip(seconds))

    # -- what the place offers -----------------------------------------------------------------------------------------

    def client_topic_type(self, topic: str) -> str | None:
        """Return the type of a topic of a client, by its name in ROS 1; None if there is none."""
        return self.offers.topics.get(topic)

    def client_topic_types(self) -> dict[str, str]:
        """Return the topics of clients and their types, by the names of ROS 1."""
        return self.offers.topics

    def client_service_type(self, service: str) -> str | None:
        """Return the type of a service of a client, by its name in ROS 1; None if there is none."""
        return self.offers.services.get(service)

    def offered_services(self) -> dict[str, str]:
        """Return the services of clients and their types, by the names of ROS 1."""
        return self.offers.services

    def offered_actions(self) -> dict[str, str]:
        """Return the actions of clients and their types, ``package/Name``."""
        return self.offers.actions

    def heard(self) -> frozenset[str]:
        """Return the topics that clients are subscribed to, whether or not they exist."""
        return frozenset(self.offers.heard)
