"""Where containers dial, by a Unix socket or from their own machine; each is handed to the place that awaits it."""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from pathlib import Path

from engine.protocols import robot_link
from engine.protocols.address import UnixAddress
from engine.protocols.framing import FrameStream
from engine.protocols.pending_handshakes import PendingHandshakes
from engine.protocols.sockets import listen
from ppaas.errors import NotPermitted, PPaaSError

logger = logging.getLogger(__name__)

HELLO_TIMEOUT = 5.0

Welcome = Callable[[robot_link.Hello, FrameStream[robot_link.FromContainer]], Awaitable[None]]
Failure = Callable[[robot_link.ContainerFailed], None]


class LinkServer:
    """Takes the first frame of each container and hands the rest on.

    Parameters
    ----------
    path : Path
        Of the socket; only this user may connect to it.
    welcome : callable
        Serves a container whose secret was right, until it hangs up.
    failed : callable
        Told of a container that cannot be what it was asked to be.
    hello_timeout : float
        Seconds that whoever dials has to say who it is.
    """

    def __init__(self, path: Path, welcome: Welcome, failed: Failure, *, hello_timeout: float = HELLO_TIMEOUT) -> None:
        self.path = path
        self._welcome = welcome
        self._failed = failed
        self._hello_timeout = hello_timeout
        self._awaited: PendingHandshakes[str | None] = PendingHandshakes()
        self._served: dict[str, FrameStream[robot_link.FromContainer]] = {}
        self._server: asyncio.Server | None = None
        self._streams: set[FrameStream[robot_link.FromContainer]] = set()

    async def start(self) -> None:
        """Listen."""
        self._server = await listen(UnixAddress(self.path), self.connected)

    def expect(self, container: str, secret: str, machine: str | None = None) -> None:
        """Await a container, once; if it comes from another host, then from this machine alone."""
        self._awaited.expect(container, secret, machine)

    def forget(self, container: str) -> None:
        """Await it no more."""
        self._awaited.forget(container)

    def hang_up(self, container: str) -> None:
        """Cut a container off that was lost with its machine: nothing that it still says is heard."""
        stream = self._served.get(container)
        if stream is not None:
            stream.abort()

    @property
    def awaited(self) -> int:
        """How many containers have not dialled yet."""
        return len(self._awaited)

    async def connected(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, machine: str | None = None
    ) -> None:
        """Serve a connection; ``machine`` is whom its certificate names, where it has come with one."""
        stream: FrameStream[robot_link.FromContainer] = FrameStream(reader, writer, robot_link.FromContainer)
        self._streams.add(stream)
        try:
            first = await self._first(stream, machine)
            if isinstance(first, robot_link.ContainerFailed):
                self._failed(first)
            else:
                await self._serve(first, stream)
        except (PPaaSError, TimeoutError) as error:
            logger.warning("a container was cut off: %s", error or "it said nothing")
        finally:
            self._streams.discard(stream)
            await stream.close()

    async def _serve(self, hello: robot_link.Hello, stream: FrameStream[robot_link.FromContainer]) -> None:
        self._served[hello.container] = stream
        try:
            await self._welcome(hello, stream)
        finally:
            del self._served[hello.container]

    async def _first(
        self, stream: FrameStream[robot_link.FromContainer], machine: str | None
    ) -> robot_link.Hello | robot_link.ContainerFailed:
        async with asyncio.timeout(self._hello_timeout):
            first = await stream.receive()
        if not isinstance(first, robot_link.Hello | robot_link.ContainerFailed):
            raise NotPermitted("something dialled the robot link that is no container")
        expected = self._awaited.admit(first.container, first.secret)
        if machine not in (None, expected):
            raise NotPermitted(f"container {first.container!r} of machine {expected!r} came from machine {machine!r}")
        return first

    async def close(self) -> None:
        """Hang up on all, and listen no more."""
        if self._server is not None:
            self._server.close()
        await asyncio.gather(*(stream.close() for stream in self._streams))
        self.path.unlink(missing_ok=True)
