"""Attachment of a socket to a session, and the session that outlives it."""

import asyncio
import secrets
from typing import NamedTuple

from endpoints.http.websocket_protocol import Probe
from endpoints.rosbridge.connect_request import ConnectRequest
from engine.sessions.place.place_link import PlaceLink
from engine.sessions.roles import Role
from engine.sessions.session import ClientSession
from ppaas.errors import PPaaSError
from ppaas.wire.resumption import ID_HEADER, NEW, RESUMED, STATE_HEADER, TAKEN_HEADER

PROBE_TIMEOUT = 2.0
"""Time limit of the probe of a robot's socket when another socket connects for the same robot [s]."""


class SessionKey(NamedTuple):
    """Key of a session: user, owner and id of the robot, role, and the name that the client gave it."""

    user: str
    owner: str
    robot: str
    role: Role
    name: str


class RetainedSession:
    """Session that outlives its sockets.

    ``taken`` counts the frames received from the client, ``attachment`` is the current socket, if any, and ``expiry``
    the timer that ends the session while no socket is attached.
    """

    def __init__(self, session: ClientSession, place: PlaceLink, key: SessionKey | None) -> None:
        self.id = secrets.token_hex(8)
        self.session = session
        self.place = place
        self.key = key
        self.taken = 0
        self.ended = False
        self.attachment: Attachment | None = None
        self.expiry: asyncio.TimerHandle | None = None


class Attachment:
    """Attachment of one socket to a session.

    Parameters
    ----------
    retained : RetainedSession
        The session.
    request : ConnectRequest
        Request of the client.
    user : str
        User of the client.
    token : str
        Id of the token that the client authenticated with.
    probe : callable
        Probes the connection.
    resumed : bool
        Whether the session was retained from an earlier socket.

    Attributes
    ----------
    displaced : Future
        Done once another socket took over the session; its result is the reason.
    """

    def __init__(
        self,
        retained: RetainedSession,
        request: ConnectRequest,
        user: str,
        token: str,
        probe: Probe,
        *,
        resumed: bool,
    ) -> None:
        self.retained = retained
        self.session = retained.session
        self.request = request
        self.user = user
        self.token = token
        self.resumed = resumed
        self.displaced: asyncio.Future[PPaaSError] = asyncio.get_running_loop().create_future()
        self._probe = probe
        self._left = asyncio.Event()

    @property
    def owner(self) -> str:
        """User to whom the robot belongs."""
        return self.request.owner or self.user

    @property
    def headers(self) -> list[tuple[bytes, bytes]]:
        """Headers of the handshake for a client that named its session."""
        if self.request.session is None:
            return []
        state = {
            STATE_HEADER: RESUMED if self.resumed else NEW,
            ID_HEADER: self.retained.id,
            TAKEN_HEADER: str(self.retained.taken),
        }
        return [(name.encode(), value.encode()) for name, value in state.items()]

    async def answers(self) -> bool:
        """Return whether the client is alive: it answers a ping or sends a frame meanwhile."""
        taken = self.retained.taken
        return await self._probe(PROBE_TIMEOUT) or self.retained.taken != taken

    async def take_over(self, why: PPaaSError) -> None:
        """Displace this socket, and wait until it is detached from the session."""
        if not self.displaced.done():
            self.displaced.set_result(why)
        await self._left.wait()

    @property
    def has_left(self) -> bool:
        """Whether the socket is detached or the session is over."""
        return self._left.is_set() or self.session.over.done()

    def detach(self) -> None:
        """Detach the socket from the session."""
        self._left.set()
        if self.retained.attachment is self:
            self.retained.attachment = None


def name_of(user: str, request: ConnectRequest) -> str:
    """Return the name of a client in the log."""
    owner = "" if request.owner in ("", user) else f"{request.owner[:64]}:"
    return f"{request.role} {user}/{owner}{request.robot[:64]}"
