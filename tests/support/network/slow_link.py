"""TCP forwarder to a cloud with a limited bandwidth."""

import asyncio
import contextlib

from tests.support.network.forwarder import Forwarder

CHUNK = 4096


class SlowLink(Forwarder):
    """Forwards TCP connections to a server with a limited bandwidth in each direction.

    Parameters
    ----------
    url : str
        URL of the server.
    rate : float
        Bandwidth [bytes/s].
    """

    def __init__(self, url: str, rate: float) -> None:
        super().__init__(url)
        self._rate = rate

    async def pipe(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Forward one direction until it ends."""
        with contextlib.suppress(ConnectionError):
            while data := await reader.read(CHUNK):
                await asyncio.sleep(len(data) / self._rate)
                writer.write(data)
                await writer.drain()
        writer.close()
