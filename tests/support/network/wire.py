"""TCP proxy between clients and a cloud that a test can cut, stall or redirect."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from urllib.parse import urlsplit


class Wire:
    """TCP proxy; it can break connections, or silently stop forwarding.

    Parameters
    ----------
    far : str
        URL of the cloud.
    """

    def __init__(self, far: str) -> None:
        self._far = far
        self._writers: set[asyncio.StreamWriter] = set()
        self._whole = True
        self._flows = asyncio.Event()
        self._flows.set()
        self.url = ""
        self.refused = 0

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if not self._whole:
            self.refused += 1
            writer.transport.abort()
            return
        flows = self._flows
        await flows.wait()
        parts = urlsplit(self._far)
        far_reader, far_writer = await asyncio.open_connection(parts.hostname, parts.port)
        self._writers |= {writer, far_writer}
        try:
            await asyncio.gather(_pass(reader, far_writer, flows), _pass(far_reader, writer, flows))
        finally:
            self._writers -= {writer, far_writer}

    def cut(self) -> None:
        """Abort all connections, and refuse new ones until ``mend``."""
        self._whole = False
        for writer in tuple(self._writers):
            writer.transport.abort()

    def mend(self, url: str | None = None) -> None:
        """Accept connections again, to another cloud if a URL is given."""
        self._far = url or self._far
        self._whole = True

    def fall_silent(self) -> None:
        """Stop forwarding on existing connections without closing them; new connections work."""
        self._flows.clear()
        self._flows = asyncio.Event()
        self._flows.set()

    def stall(self) -> None:
        """Stop forwarding on all connections, old and new, until ``flow``; nothing is lost."""
        self._flows.clear()

    def flow(self) -> None:
        """Resume forwarding."""
        self._flows.set()


async def _pass(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, flows: asyncio.Event) -> None:
    with contextlib.suppress(ConnectionError):
        while data := await reader.read(1 << 16):
            await flows.wait()
            writer.write(data)
            await writer.drain()
    writer.close()


@asynccontextmanager
async def wire_to(url: str) -> AsyncIterator[Wire]:
    """Open a proxy to a cloud; clients connect to its ``url``."""
    wire = Wire(url)
    server = await asyncio.start_server(wire._connected, "127.0.0.1", 0)
    wire.url = "http://{}:{}".format(*server.sockets[0].getsockname()[:2])
    try:
        yield wire
    finally:
        server.close()
        wire.cut()
