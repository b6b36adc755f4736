"""Session frames: messages of the robot link by which an endpoint carries sockets to the sessions of a container.

A socket has a number on its link, and each frame of its client a number in its session. The endpoint keeps each frame
until the container reports it as *settled*: what it caused is in a stored checkpoint, was answered, or may be lost. A
container that replaces another gets all frames that are not settled, when the endpoint attaches its sockets there.
"""

import msgspec

from engine.protocols.refusals import Refusal
from engine.rights.access import Access
from engine.rights.roles import Role
from ppaas.wire.operations import Level
from ppaas.wire.resumption import ResumptionPoint


class SessionClient(msgspec.Struct, frozen=True):
    """Client of a session.

    Parameters
    ----------
    user : str
        User of the client.
    owner, robot : str
        User and id of the robot.
    role : {"robot", "operator"}
        Role of the client.
    name : str, optional
        Name that the client gave its session; without one, the session ends with its socket.
    """

    user: str
    owner: str
    robot: str
    role: Role
    name: str | None = None

    @property
    def title(self) -> str:
        """Name of the client in the log."""
        owner = "" if self.owner == self.user else f"{self.owner[:64]}:"
        return f"{self.role} {self.user}/{owner}{self.robot[:64]}"


class SessionOptions(msgspec.Struct, frozen=True):
    """Options of a session, as the client requested them in its address.

    Parameters
    ----------
    level : str
        Initial status level.
    namespace : str, optional
        Namespace of the robot's names in the client's software.
    compact : bool
        Whether velocities are sent as compact frames.
    png : bool
        Whether the client reads the operation ``png``.
    counts : bool
        Whether the client counts frames.
    linger : float
        Time for which the session is retained without a socket [s].
    software : str
        Software of the client, as it names it; empty if it does not.
    """

    level: Level = "none"
    namespace: str | None = None
    compact: bool = False
    png: bool = True
    counts: bool = False
    linger: float = 0.0
    software: str = ""


class NumberedFrame(msgspec.Struct, frozen=True, array_like=True):
    """Frame of a client, text in UTF-8 or binary, with its number in the session."""

    number: int
    content: bytes
    binary: bool = False


# -- endpoint → container ----------------------------------------------------------------------------------------------


class Attach(msgspec.Struct, tag="attach"):
    """Attach a socket to a session.

    Parameters
    ----------
    socket : int
        Number of the socket on this link.
    client : SessionClient
    options : SessionOptions
    access : Access
        Rights of the client.
    id : str
        Id of the session, if it is new or is carried already.
    resume : ResumptionPoint, optional
        Point at which the client resumes its session.
    carried : bool
        Whether the endpoint carries this session already: the container replaces another. Then ``kept`` has the frames
        that are not settled, and ``sent`` is the number of frames that the client was sent.
    since : int
        Number of the last frame that the client had sent before it came to this endpoint, which keeps none of these.
    settled : list of int
        The frames among them that were settled while the client was at this endpoint.
    """

    socket: int
    client: SessionClient
    options: SessionOptions
    access: Access
    id: str
    resume: ResumptionPoint | None = None
    carried: bool = False
    kept: list[NumberedFrame] = []
    taken: int = 0
    sent: int = 0
    since: int = 0
    settled: list[int] = []


class ClientFrame(msgspec.Struct, tag="frame"):
    """Frame of the client of a socket."""

    socket: int
    frame: NumberedFrame


class SocketReady(msgspec.Struct, tag="ready"):
    """The socket accepts frames again, or no longer: its client reads too slowly."""

    socket: int
    ready: bool


class AccessChanged(msgspec.Struct, tag="access"):
    """The rights of the client of a socket have changed."""

    socket: int
    access: Access


class Detach(msgspec.Struct, tag="detach"):
    """The socket is closed; ``for_good``: the client does not come back."""

    socket: int
    for_good: bool


class Inform(msgspec.Struct, tag="inform"):
    """Send the client of a socket a status of level info."""

    socket: int
    slug: str
    text: str


class RoundTrip(msgspec.Struct, tag="round_trip"):
    """Round trip of a ping to the robot [s]."""

    seconds: float


class PlanCounted(msgspec.Struct, tag="plan_counted"):
    """A path that the client of a socket requests counts against the quota of its user, or is refused."""

    socket: int
    refusal: Refusal | None = None


SessionToContainer = Attach | ClientFrame | SocketReady | AccessChanged | Detach | Inform | RoundTrip | PlanCounted

# -- container → endpoint ----------------------------------------------------------------------------------------------


class Attached(msgspec.Struct, tag="attached"):
    """The socket is attached: id of the session, whether it was resumed, and how many of its frames were taken."""

    socket: int
    id: str
    resumed: bool
    taken: int


class SocketFrame(msgspec.Struct, tag="out"):
    """Frame for the client of a socket, text in UTF-8 or binary; it settles frames of the client."""

    socket: int
    content: bytes
    binary: bool = False
    settled: tuple[int, ...] = ()


class Settled(msgspec.Struct, tag="settled"):
    """Client frames that a replacement container does not need."""

    socket: int
    numbers: list[int]


class SessionOver(msgspec.Struct, tag="over"):
    """The session has ended, or another socket took it over."""

    socket: int
    reason: Refusal
    taken_over: bool = False


class CountPlan(msgspec.Struct, tag="count_plan"):
    """The client of a socket requests a path: count it."""

    socket: int


class ClientOffers(msgspec.Struct, tag="client_offers"):
    """Topics, services and actions of the clients of the place with their types, and the topics that they heard."""

    topics: dict[str, str]
    services: dict[str, str]
    actions: dict[str, str]
    heard: list[str]


SessionFromContainer = Attached | SocketFrame | Settled | SessionOver | CountPlan | ClientOffers
