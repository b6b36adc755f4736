"""A way to a cloud that carries few bytes a second, as a bad link does."""

import asyncio
import contextlib

from tests.support.network.forwarder import Forwarder

CHUNK = 4096


class SlowLink(Forwarder):
    """Carries connections to a server at so many bytes a second, each way.

    Parameters
    ----------
    url : str
        Of the server.
    rate : float
        [bytes/s].
    """

    def __init__(self, url: str, rate: float) -> None:
        super().__init__(url)
        self._rate = rate

    async def pipe(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Carry one way, until it ends."""
        with contextlib.suppress(ConnectionError):
            while data := await reader.read(CHUNK):
                await asyncio.sleep(len(data) / self._rate)
                writer.write(data)
                await writer.drain()
        writer.close()
