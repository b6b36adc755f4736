"""The way of a machine's containers to an endpoint on another host.

A container dials a Unix socket, as it does where the endpoint is on its own machine, and the machine carries its bytes
on over TLS. So no container holds the key of its machine, with which it could pass for it, and none needs a network.
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
"""Bytes that are carried at a time."""


class Relay:
    """Carries what containers and their endpoint say to each other, unread; who reads slowly slows the other down.

    Parameters
    ----------
    path : Path
        Of the socket; only this user may connect to it.
    dial : callable
        Connects to the endpoint.
    """

    def __init__(self, path: Path, dial: Callable[[], Awaitable[Streams]]) -> None:
        self.path = path
        self._dial = dial
        self._server: asyncio.Server | None = None
        self._open: set[asyncio.StreamWriter] = set()

    async def start(self) -> None:
        """Listen."""
        self._server = await listen(UnixAddress(self.path), self._connected)

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            far_reader, far_writer = await self._dial()
        except Unavailable as error:
            logger.warning("a container did not reach its endpoint: %s", error)
            writer.close()
            return
        both = {writer, far_writer}
        self._open |= both
        ways = [asyncio.create_task(_carry(reader, far_writer)), asyncio.create_task(_carry(far_reader, writer))]
        try:
            await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
        finally:
            self._open -= both
            for end in both:
                end.close()  # what was written still goes
            for way in ways:
                way.cancel()
            await asyncio.gather(*ways, return_exceptions=True)

    async def close(self) -> None:
        """Hang up on all, and listen no more."""
        if self._server is not None:
            self._server.close()
        for writer in tuple(self._open):
            writer.transport.abort()
        self.path.unlink(missing_ok=True)


async def _carry(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    with contextlib.suppress(OSError):  # either end has gone, which ends the other
        while data := await reader.read(CHUNK):
            writer.write(data)
            await writer.drain()
