"""Place link: the endpoint's end of the robot link, which carries the sockets of a robot and its operators.

Endpoints call services of the clone by it, and subscribe to its topics themselves. The sessions of clients are in the
container (`engine.sessions`).
"""

import itertools
from collections.abc import Callable
from typing import ParamSpec

from engine.links.container_link import ContainerLink, Stream
from engine.protocols import robot_link, session_frames
from engine.protocols.session_frames import ClientOffers, SessionToContainer
from engine.service.links.carried_session import CarriedSession
from ppaas.errors import PPaaSError
from ppaas.nodes.frames import BASE_LINK

P = ParamSpec("P")

EndpointOrder = Callable[[int], robot_link.DialEndpoint]
"""Returns the order to dial an endpoint for a container, given its number among those of the place."""


class PlaceLink(ContainerLink):
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

    # -- frames of the container ---------------------------------------------------------------------------------------

    def begin(self, hello: robot_link.Hello, stream: Stream) -> None:
        """Serve a container: attach the sockets there, and let it dial the endpoints of the place."""
        super().begin(hello, stream)
        self._count += 1
        for order in self._endpoints.values():
            self._write(order(self._count))
        for session in tuple(self._carried.values()):
            self._guard(session, session.attach)

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
            case _:
                super().take(frame)

    def close(self, reason: PPaaSError) -> None:
        """Close the place, and notify all clients."""
        super().close(reason)
        for session in tuple(self._carried.values()):
            session.closed(reason)

    def _guard(self, session: CarriedSession, work: Callable[P, None], *args: P.args, **kwargs: P.kwargs) -> None:
        """Let a session do work; one that fails ends, and the others go on."""
        fault = self._faults.call(f"a session of {self.key}", work, *args, **kwargs)
        if fault is not None:
            session.closed(fault)

    # -- endpoints -----------------------------------------------------------------------------------------------------

    def add_endpoint(self, name: str, order: EndpointOrder) -> None:
        """Let the containers of the place dial an endpoint; ``order`` is called for each with its number."""
        if name not in self._endpoints:
            self._endpoints[name] = order
            self._write(order(self._count))

    def drop_endpoint(self, endpoint: str) -> None:
        """Let the containers of the place leave an endpoint."""
        if self._endpoints.pop(endpoint, None) is not None:
            self._write(robot_link.LeaveEndpoint(endpoint))

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

    def send(self, frame: SessionToContainer) -> bool:
        """Send a frame about a socket to the container; return whether there is one."""
        if self._stream is None:
            return False
        self._stream.write(frame)
        return True

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
