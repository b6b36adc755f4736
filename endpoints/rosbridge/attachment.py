"""Attachment of a socket to a session in the container of its place."""

import asyncio
from typing import NamedTuple

from endpoints.http.websocket_protocol import Probe
from endpoints.rosbridge.connect_request import ConnectRequest
from engine.service.links.carried_session import CarriedSession
from engine.service.links.place_link import PlaceLink
from ppaas.errors import PPaaSError
from ppaas.wire.resumption import ENDPOINT_HEADER, ID_HEADER, NEW, RESUMED, STATE_HEADER, TAKEN_HEADER

PROBE_TIMEOUT = 2.0
"""Time limit of the probe of a robot's socket when another socket connects for the same robot [s]."""


class Caller(NamedTuple):
    """User of a client, id of the token that it authenticated with, and the probe of its connection."""

    user: str
    token: str
    probe: Probe


class Attachment:
    """Attachment of one socket to a session.

    Parameters
    ----------
    session : CarriedSession
        The session, as this endpoint carries it.
    place : PlaceLink
        Place of the robot.
    request : ConnectRequest
        Request of the client.
    caller : Caller
        The client.

    Attributes
    ----------
    user, token : str
        User of the client, and id of the token that it authenticated with.
    """

    def __init__(self, session: CarriedSession, place: PlaceLink, request: ConnectRequest, caller: Caller) -> None:
        self.session = session
        self.place = place
        self.request = request
        self.user, self.token, self._probe = caller
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
            STATE_HEADER: RESUMED if self.session.resumed else NEW,
            ID_HEADER: self.session.id,
            TAKEN_HEADER: str(self.session.taken),
        }
        if self.place.nearer:
            state[ENDPOINT_HEADER] = self.place.nearer
        return [(name.encode(), value.encode()) for name, value in state.items()]

    @property
    def displaced(self) -> asyncio.Future[PPaaSError]:
        """Future that is done once another socket took over the session; its result is the reason."""
        return self.session.displaced

    async def answers(self) -> bool:
        """Return whether the client is alive: it answers a ping or sends a frame meanwhile."""
        taken = self.session.taken
        return await self._probe(PROBE_TIMEOUT) or self.session.taken != taken

    async def take_over(self, why: PPaaSError) -> None:
        """Displace this socket, and wait until it is detached from the session."""
        self.session.displace(why)
        await self._left.wait()

    @property
    def has_left(self) -> bool:
        """Whether the socket is detached or the session is over."""
        return self._left.is_set() or self.session.over.done()

    def detach(self, *, for_good: bool) -> None:
        """Detach the socket from the session, which is retained for a while unless the client left for good."""
        self._left.set()
        self.session.detach(for_good=for_good)
