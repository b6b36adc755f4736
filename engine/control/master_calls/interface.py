"""Calls between the master and one endpoint of a cloud: what each may ask of the other.

An endpoint serves sockets and REST. The master decides about places, machines and quotas. The endpoint registers once
it is connected, and says again which clients it has when it finds another master.
"""

from typing import Annotated, Protocol

import msgspec

from engine.calls.interface import wire_name
from engine.control.counts import REQUEST_SECONDS
from engine.control.news import FactKind, NewsKind
from engine.protocols.address import EndpointAddress
from engine.protocols.versions import Protocols
from engine.specs.containers import MapVersion
from engine.specs.start_state import StartState
from ppaas.errors import PPaaSError

_CLASSES = msgspec.Meta(min_length=len(REQUEST_SECONDS) + 1, max_length=len(REQUEST_SECONDS) + 1)


class RequestCounts(msgspec.Struct, frozen=True):
    """Requests by HTTP that an endpoint has answered since it started, but for WebSockets.

    Parameters
    ----------
    statuses : tuple of int
        Number of answers of each class of status, from 1xx to 5xx.
    seconds : list of int
        Number of answers in each class of `REQUEST_SECONDS`, by the time until the answer began.
    total : float
        Sum of these times [s].
    """

    statuses: tuple[int, int, int, int, int] = (0, 0, 0, 0, 0)
    seconds: Annotated[list[int], _CLASSES] = msgspec.field(default_factory=lambda: [0] * (len(REQUEST_SECONDS) + 1))
    total: float = 0.0


class EndpointState(msgspec.Struct, frozen=True):
    """Load of an endpoint.

    Parameters
    ----------
    sockets : int
        Number of sockets of robots and operators.
    frames : float
        Frames that clients sent [1/s].
    cpu : float
        CPU in use [cores].
    memory : int
        Memory in use [bytes].
    requests : RequestCounts
    """

    sockets: int
    frames: float
    cpu: float
    memory: int
    requests: RequestCounts = RequestCounts()


class ReportAnswer(msgspec.Struct, frozen=True):
    """Answer of the master to a report.

    Parameters
    ----------
    leads : bool
        Whether this master leads now.
    start : StartState
        Whether containers can start, and the kernels that machines compile.
    """

    leads: bool
    start: StartState


class Registration(msgspec.Struct, frozen=True):
    """First call of an endpoint.

    Parameters
    ----------
    endpoint : str
        Name of the endpoint, unique in the cloud: that of its machine, a hyphen and a number.
    secret : str
        Secret of the cloud's own processes; empty on another host, whose certificate identifies it.
    release : str
        Release of its software.
    pid : int
    at : EndpointAddress
        Addresses that containers dial.
    container_secret : str
        Secret from which those of the containers are derived (``place_secret``).
    url : str
        Address at which it serves clients.
    advertised : str
        Address that clients whose container is on its machine are told; empty for none.
    protocols : Protocols, optional
        Protocol versions that it speaks; None if its release states none.
    """

    endpoint: str
    secret: str
    release: str
    pid: int
    at: EndpointAddress
    container_secret: str
    url: str
    advertised: str = ""
    protocols: Protocols | None = None


class ClientJoin(msgspec.Struct, frozen=True):
    """Client of an endpoint that joins the place of a robot; see ``RobotSessions.join``.

    Parameters
    ----------
    user, robot : str
    as_robot, hold, queue : bool
    session : str, optional
        Name of the session of a robot, by which it takes over from its own earlier socket.
    """

    user: str
    robot: str
    as_robot: bool
    hold: bool
    queue: bool
    session: str | None = None


class JoinedPlace(msgspec.Struct, frozen=True):
    """Place that a client has joined.

    Parameters
    ----------
    key : str
        Name of the place.
    base_frame : str
        Frame in which the robot is driven.
    position : int, optional
        Position in the queue, from 1; None if it is not queued.
    nearer : str
        Address of an endpoint on the machine of the robot's container, for its next connection; empty if there is none,
        or if this one is.
    """

    key: str
    base_frame: str
    position: int | None
    nearer: str = ""


class MasterCalls(Protocol):
    """Methods of the master that depend on the endpoint that calls them."""

    @wire_name("register")  # of all releases, so that an endpoint of another one is refused by its release
    async def register(self, registration: Registration) -> None:
        """Register an endpoint; the first call on its link.

        Raises
        ------
        Conflict
            It speaks no protocol of this master.
        NotPermitted
            The secret is wrong.
        """
        ...

    async def report(self, state: EndpointState) -> ReportAnswer:
        """Report the load of the endpoint; return the state of the master."""
        ...

    # -- places --------------------------------------------------------------------------------------------------------

    async def join(self, join: ClientJoin) -> JoinedPlace:
        """Add a client to the place of a robot, and let its containers dial the endpoint; see ``RobotSessions.join``.

        Raises
        ------
        Conflict
            The robot is connected already, at this endpoint or another, and its socket answers.
        """
        ...

    async def leave(self, key: str, as_robot: bool) -> None:
        """Remove a client from a place."""
        ...

    async def let_go(self, key: str, reason: PPaaSError) -> None:
        """Close a place although clients are connected, and notify them of the reason."""
        ...

    async def position(self, key: str) -> int | None:
        """Return the position of a place in the queue, from 1; None if it is not queued."""
        ...

    async def visit(self, user: str, robot: str) -> JoinedPlace:
        """Let the containers of a robot's place dial the endpoint, which calls services there.

        Raises
        ------
        Unavailable
            The robot has no container now.
        """
        ...

    async def open_planning(self, user: str, version: MapVersion, labels: dict[str, str], queue: bool) -> JoinedPlace:
        """Open the place of a planning container, or use it; see ``Planning.place``."""
        ...

    async def announce(self, kind: NewsKind, key: str) -> None:
        """Tell the other processes of the cloud that this endpoint has changed a record."""
        ...

    async def facts(self, kind: FactKind, user: str, robot: str) -> list[bytes]:
        """Return what the other processes of the cloud know of a robot, as JSON."""
        ...

    async def forget_place(self, key: str) -> None:
        """Let the containers of a place leave the endpoint."""
        ...


class EndpointCalls(Protocol):
    """Methods of an endpoint that the master calls."""

    async def place_closed(self, key: str, reason: PPaaSError) -> None:
        """Handle that a place was closed: its clients here are notified of the reason."""
        ...

    async def hear(self, kind: NewsKind, key: str) -> None:
        """Drop a record from caches, as another process has changed it."""
        ...

    async def fact(self, kind: FactKind, user: str, robot: str) -> bytes | None:
        """Return what the endpoint knows of a robot, as JSON; None if it does not know it."""
        ...

    async def displace(self, user: str, robot: str, session: str | None) -> None:
        """Displace the socket of a robot that connects at another endpoint, if it is dead or of the same session."""
        ...
