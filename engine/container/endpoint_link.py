"""The container's end of the robot link, which outlives an endpoint that was killed.

The container dials again, for as long as its machine lets it live, and says hello to whoever answers: at once when its
machine tells that an endpoint came, and from time to time by itself.
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
"""Seconds before the first, second … try; the last stays."""

STEADY = 5.0
"""Seconds that an endpoint stays for the next loss of it to be a first one."""

Stream = FrameStream[robot_link.ToContainer]


async def dial(path: str) -> Stream:
    """Dial the endpoint by its Unix socket; ``OSError`` where nobody answers."""
    return FrameStream(*await asyncio.open_unix_connection(path), robot_link.ToContainer)


class EndpointLink:
    """What a container writes to, and hears.

    Parameters
    ----------
    path : str
        Unix socket of the endpoint, or of what leads there.
    stream : FrameStream
        The first connection.
    """

    def __init__(self, path: str, stream: Stream) -> None:
        self._path = path
        self.stream = stream
        self._stopped = False
        self._came = asyncio.Event()
        self.is_up = True

    def came(self) -> None:
        """Take note that an endpoint awaits this container: robots wait for it to dial."""
        self._came.set()

    def write(self, frame: msgspec.Struct) -> None:
        """Queue a frame; while there is no endpoint it is lost."""
        self.stream.write(frame)

    @property
    def waiting(self) -> int:
        """Bytes written that the endpoint has not yet taken."""
        return self.stream.waiting

    async def serve(
        self,
        take: Callable[[robot_link.ToContainer], bool],
        hello: Callable[[], robot_link.Hello],
        lost: Callable[[], None],
    ) -> None:
        """Hand each frame to ``take``, until that returns false; dial again and say hello as often as need be.

        Parameters
        ----------
        take : callable
            Takes a frame; returns false where that was the last.
        hello : callable
            Returns what the next endpoint is told first.
        lost : callable
            Told when there is no endpoint any more.
        """
        loop, tries = asyncio.get_running_loop(), 0
        while True:
            began = loop.time()
            await self.stream.each(lambda frame: self._take(frame, take))
            if self._stopped:
                return
            self.is_up = False
            lost()
            tries = 0 if loop.time() - began > STEADY else tries
            tries = await self._dial_again(tries)
            self.stream.write(hello())

    def _take(self, frame: robot_link.ToContainer, take: Callable[[robot_link.ToContainer], bool]) -> bool:
        self._stopped = not take(frame)
        return not self._stopped

    async def _dial_again(self, tries: int) -> int:
        await self.stream.close()
        while True:
            await self._wait(RETRIES[min(tries, len(RETRIES) - 1)])
            tries += 1
            try:
                self.stream = await dial(self._path)
            except OSError as error:
                logger.debug("no endpoint yet: %s", error)
            else:
                self.is_up = True
                return tries

    async def _wait(self, seconds: float) -> None:
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                await self._came.wait()
        self._came.clear()

    async def close(self) -> None:
        """Hang up."""
        await self.stream.close()
