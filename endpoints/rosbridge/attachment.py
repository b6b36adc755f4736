"""Attachment of a socket to a session, and the session that outlives it."""

import asyncio
import secrets
from typing import NamedTuple

from endpoints.http.websocket_protocol import Probe
from endpoints.rosbridge.connect_request import ConnectRequest
from endpoints.rosbridge.roles import Role
from endpoints.rosbridge.session import ClientSession
from engine.service.links.place_link import PlaceLink
from ppaas.errors import PPaaSError
from ppaas.wire.resumption import ID_HEADER, NEW, RESUMED, STATE_HEADER, TAKEN_HEADER

PROBE_TIMEOUT = 2.0
"""Seconds that the socket of a robot may be silent when another comes for the same robot; then it is dead."""


class SessionKey(NamedTuple):
    """Whose session it is."""

    user: str
    robot: str
    role: Role
    name: str


class RetainedSession:
    """A session and what is known of it here; its ``taken`` counts the frames that were taken from the client."""

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
    """One socket's hold of a session.

    Attributes
    ----------
    displaced : Future
        Done once the session was given to another socket; its result is what this one is told.
    """

    def __init__(
        self, retained: RetainedSession, request: ConnectRequest, user: str, probe: Probe, *, resumed: bool
    ) -> None:
        self.retained = retained
        self.session = retained.session
        self.request = request
        self.user = user
        self.resumed = resumed
        self.displaced: asyncio.Future[PPaaSError] = asyncio.get_running_loop().create_future()
        self._probe = probe
        self._left = asyncio.Event()

    @property
    def headers(self) -> list[tuple[bytes, bytes]]:
        """What the handshake tells a client that named its session."""
        if self.request.session is None:
            return []
        told = {
            STATE_HEADER: RESUMED if self.resumed else NEW,
            ID_HEADER: self.retained.id,
            TAKEN_HEADER: str(self.retained.taken),
        }
        return [(name.encode(), value.encode()) for name, value in told.items()]

    async def answers(self) -> bool:
        """Tell whether the client is still there: it answers a ping, or says something meanwhile."""
        taken = self.retained.taken
        return await self._probe(PROBE_TIMEOUT) or self.retained.taken != taken

    async def take_over(self, why: PPaaSError) -> None:
        """Take the session from this socket, and wait until it touches it no more."""
        if not self.displaced.done():
            self.displaced.set_result(why)
        await self._left.wait()

    @property
    def has_left(self) -> bool:
        """The socket is gone, or the place is no more."""
        return self._left.is_set() or self.session.over.done()

    def detach(self) -> None:
        """Touch the session no more."""
        self._left.set()
        if self.retained.attachment is self:
            self.retained.attachment = None
