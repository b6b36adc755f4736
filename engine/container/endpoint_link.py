"""Endpoint link: the container's end of the robot link, which reconnects after the endpoint was killed.

The container dials until its machine stops it, and sends its hello to the endpoint that answers. It dials at once when
its machine notifies it that an endpoint listens, and otherwise with increasing delays.
"""

import asyncio
import contextlib
import logging
from collections.abc import Callable

import msgspec

from engine.protocols import robot_link
from engine.protocols.framing import FrameStream

logger = logging.getLogger(__name__)

RETRIES = (0.1, 0.2, 0.4, 0.8)
"""Delays before the first, second … attempt [s]; the last is repeated."""

STEADY = 5.0
"""Duration of a connection after which the delays start from the first again [s]."""

Stream = FrameStream[robot_link.ToContainer]


async def dial(path: str) -> Stream:
    """Dial the endpoint's Unix socket; ``OSError`` if it does not answer."""
    return FrameStream(*await asyncio.open_unix_connection(path), robot_link.ToContainer)


class EndpointLink:
    """Connection of a container to its endpoint, replaced by a new one when it is lost.

    Parameters
    ----------
    path : str
        Path of the Unix socket of the endpoint, or of the relay to it.
    stream : FrameStream
        The first connection.
    """

    def __init__(self, path: str, stream: Stream) -> None:
        self._path = path
        self.stream = stream
        self._came = asyncio.Event()
        self.is_up = True

    def came(self) -> None:
        """Dial at once: an endpoint listens again, and robots wait for this container."""
        self._came.set()

    def write(self, frame: msgspec.Struct) -> None:
        """Queue a frame; it is lost while no endpoint is connected."""
        self.stream.write(frame)

    @property
    def waiting(self) -> int:
        """Number of written bytes that are still queued for the endpoint."""
        return self.stream.waiting

    async def serve(
        self,
        take: Callable[[robot_link.ToContainer], bool],
        hello: Callable[[], robot_link.Hello],
        lost: Callable[[], None],
    ) -> None:
        """Pass each frame to ``take`` until it returns false; after a lost connection, dial again and send the hello.

        Parameters
        ----------
        take : callable
            Handles a frame; returns false if it was the last.
        hello : callable
            Returns the first frame for the next endpoint.
        lost : callable
            Called when the connection to the endpoint is lost.
        """
        loop, tries = asyncio.get_running_loop(), 0
        while True:
            began = loop.time()
            if await self.stream.each(take):
                return
            self.is_up = False
            lost()
            tries = 0 if loop.time() - began > STEADY else tries
            tries = await self._dial_again(tries)
            self.stream.write(hello())

    async def _dial_again(self, tries: int) -> int:
        await self.stream.close()
        while True:
            await self._wait(RETRIES[min(tries, len(RETRIES) - 1)])
            tries += 1
            try:
                self.stream = await dial(self._path)
            except OSError as error:
                logger.debug("the endpoint is not reachable yet: %s", error)
            else:
                self.is_up = True
                return tries

    async def _wait(self, seconds: float) -> None:
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                await self._came.wait()
        self._came.clear()

    async def close(self) -> None:
        """Close the connection."""
        await self.stream.close()
