"""Robot link relay: forwards the robot links of a machine's containers to an endpoint on another host.

A container dials a Unix socket, as with an endpoint on its own machine, and the agent forwards the bytes over TLS. So a
container neither holds the key of its machine, with which it could impersonate the machine, nor needs a network.
"""

import asyncio
import contextlib
import logging
from collections.abc import Awaitable, Callable
from pathlib import Path

from engine.protocols.address import UnixAddress
from engine.protocols.sockets import Streams, listen
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

CHUNK = 1 << 16
"""Largest number of bytes forwarded at once."""


class Relay:
    """Forwards bytes between containers and their endpoint, without decoding them; a slow reader slows the sender down.

    Parameters
    ----------
    path : Path
        Path of the Unix socket; only the user of this process may connect to it.
    dial : callable
        Connects to the endpoint at an address; raises ``Unavailable`` if it does not answer.
    where : callable
        Returns the current address of the endpoint.
    """

    def __init__(self, path: Path, dial: Callable[[str], Awaitable[Streams]], where: Callable[[], str]) -> None:
        self.path = path
        self._dial = dial
        self._where = where
        self._server: asyncio.Server | None = None
        self._open: dict[asyncio.StreamWriter, str] = {}

    async def start(self) -> None:
        """Start to listen on the socket."""
        self._server = await listen(UnixAddress(self.path), self._connected)

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        address = self._where()
        try:
            far_reader, far_writer = await self._dial(address)
        except Unavailable as error:
            logger.warning("a container could not connect to its endpoint: %s", error)
            writer.close()
            return
        both = dict.fromkeys((writer, far_writer), address)
        self._open |= both
        try:
            await carry_both_ways((reader, writer), (far_reader, far_writer))
        finally:
            for end in both:
                del self._open[end]

    def leave_others(self) -> None:
        """Abort the connections to other addresses than the current one: a stopped endpoint never closes them."""
        for writer, address in tuple(self._open.items()):
            if address != self._where():
                writer.transport.abort()

    async def close(self) -> None:
        """Stop listening, and close all connections."""
        if self._server is not None:
            self._server.close()
        for writer in tuple(self._open):
            writer.transport.abort()
        self.path.unlink(missing_ok=True)


async def carry_both_ways(near: Streams, far: Streams) -> None:
    """Forward bytes between two connections until one of them ends; then close both."""
    ways = [asyncio.create_task(_carry(near[0], far[1])), asyncio.create_task(_carry(far[0], near[1]))]
    try:
        await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for end in (near[1], far[1]):
            end.close()  # what was written is still sent
        for way in ways:
            way.cancel()
        await asyncio.gather(*ways, return_exceptions=True)


async def _carry(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    with contextlib.suppress(OSError):  # one end disconnected: the caller closes the other
        while data := await reader.read(CHUNK):
            writer.write(data)
            await writer.drain()
