"""Listener of an endpoint for containers: each names its place, and knows the secret of it."""

import asyncio
import logging
import secrets
from collections.abc import Callable
from pathlib import Path

from engine.protocols import robot_link
from engine.protocols.address import UnixAddress
from engine.protocols.framing import FrameStream
from engine.protocols.pending_handshakes import is_same
from engine.protocols.place_secret import place_secret
from engine.protocols.sockets import listen
from engine.service.links.place_link import PlaceLink
from ppaas.errors import NotPermitted, PPaaSError

logger = logging.getLogger(__name__)

HELLO_TIMEOUT = 5.0
"""Time within which a connected container must send its first frame [s]."""


class LinkListener:
    """Passes the link of each container to its place.

    Parameters
    ----------
    path : Path
        Path of the Unix socket; only this user may connect to it.
    place : callable
        Returns the link of a place by name.

    Attributes
    ----------
    secret : str
        Secret from which those of the places are derived.
    """

    def __init__(self, path: Path, place: Callable[[str], PlaceLink]) -> None:
        self.path = path
        self.secret = secrets.token_urlsafe(24)
        self._place = place
        self._server: asyncio.Server | None = None
        self._streams: set[FrameStream[robot_link.FromContainer]] = set()

    @property
    def address(self) -> str:
        """Address that containers dial."""
        return str(UnixAddress(self.path))

    async def start(self) -> None:
        """Start to listen on the socket."""
        self._server = await listen(UnixAddress(self.path), self._connected)

    def _is_of_place(self, hello: robot_link.Hello) -> bool:
        return is_same(place_secret(self.secret, hello.place), hello.secret)

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        stream: FrameStream[robot_link.FromContainer] = FrameStream(reader, writer, robot_link.FromContainer)
        self._streams.add(stream)
        try:
            async with asyncio.timeout(HELLO_TIMEOUT):
                hello = await stream.receive()
            if not isinstance(hello, robot_link.Hello) or not self._is_of_place(hello):
                raise NotPermitted("a container without the secret of its place dialled this endpoint")
            await self._place(hello.place).serve(hello, stream)
        except (PPaaSError, TimeoutError) as error:
            logger.warning("closed a link of a container: %s", error or "it sent no first frame in time")
        finally:
            self._streams.discard(stream)
            await stream.close()

    async def close(self) -> None:
        """Stop listening, and close all links."""
        if self._server is not None:
            self._server.close()
        await asyncio.gather(*(stream.close() for stream in self._streams))
        self.path.unlink(missing_ok=True)
