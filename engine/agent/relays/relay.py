"""Relay: forwards bytes between a machine's containers and other processes of the cloud."""

import asyncio
import contextlib
import logging
from abc import ABC, abstractmethod
from pathlib import Path

from engine.protocols.address import UnixAddress
from engine.protocols.sockets import Streams, listen
from ppaas.errors import PPaaSError

logger = logging.getLogger(__name__)

CHUNK = 1 << 16
"""Largest number of bytes forwarded at once."""


class Relay(ABC):
    """Forwards bytes without decoding them; a slow reader slows the sender down.

    Parameters
    ----------
    path : Path
        Path of the Unix socket that containers dial; only the user of this process may connect to it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._server: asyncio.Server | None = None
        self._open: dict[asyncio.StreamWriter, str] = {}

    @abstractmethod
    async def _dial(self, reader: asyncio.StreamReader) -> tuple[str, Streams]:
        """Connect to the address to which the connection of a container is forwarded; return both.

        Raises
        ------
        PPaaSError, TimeoutError, ValueError
            The connection is closed.
        """

    async def start(self) -> None:
        """Start to listen on the socket."""
        self._server = await listen(UnixAddress(self.path), self._connected)

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._open[writer] = ""
        try:
            address, (far_reader, far_writer) = await self._dial(reader)
        except (PPaaSError, TimeoutError, ValueError) as error:
            logger.warning("a container could not connect to its endpoint: %s", str(error) or "it named none in time")
            del self._open[writer]
            writer.close()
            return
        self._open |= dict.fromkeys((writer, far_writer), address)
        try:
            await _carry_both_ways((reader, writer), (far_reader, far_writer))
        finally:
            for end in (writer, far_writer):
                del self._open[end]

    async def close(self) -> None:
        """Stop listening, and close all connections."""
        if self._server is not None:
            self._server.close()
        for writer in tuple(self._open):
            writer.transport.abort()
        self.path.unlink(missing_ok=True)


async def _carry_both_ways(near: Streams, far: Streams) -> None:
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
