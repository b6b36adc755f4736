"""Server of the robot links: admits containers, local or of other hosts, and passes each to its place."""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from pathlib import Path

from engine.protocols import robot_link
from engine.protocols.address import UnixAddress
from engine.protocols.framing import FrameStream
from engine.protocols.handshakes import PendingHandshakes
from engine.protocols.sockets import listen
from ppaas.errors import NotPermitted, PPaaSError

logger = logging.getLogger(__name__)

HELLO_TIMEOUT = 5.0
"""Time within which a connected container must send its first frame [s]."""

Welcome = Callable[[robot_link.Hello, FrameStream[robot_link.FromContainer]], Awaitable[None]]
_First = robot_link.Hello | robot_link.ContainerFailed | robot_link.KernelsAwaited
Failure = Callable[[robot_link.ContainerFailed], None]


class LinkServer:
    """Checks the first frame of each container, and passes its stream on.

    Parameters
    ----------
    path : Path
        Path of the Unix socket; only this user may connect to it.
    welcome : callable
        Serves a container with a valid secret until it disconnects.
    failed : callable
        Called with the report of a container that failed to start.
    hello_timeout : float
        Time within which a connected container must send its first frame [s], and the next while it waits for kernels.
    waits : callable
        Called with the id of a container each time that it reports to wait for kernels.
    """

    def __init__(
        self,
        path: Path,
        welcome: Welcome,
        failed: Failure,
        *,
        hello_timeout: float = HELLO_TIMEOUT,
        waits: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._waits = waits
        self.path = path
        self._welcome = welcome
        self._failed = failed
        self._hello_timeout = hello_timeout
        self._awaited: PendingHandshakes[str | None] = PendingHandshakes()
        self._served: dict[str, FrameStream[robot_link.FromContainer]] = {}
        self._server: asyncio.Server | None = None
        self._streams: set[FrameStream[robot_link.FromContainer]] = set()

    async def start(self) -> None:
        """Start to listen on the socket."""
        self._server = await listen(UnixAddress(self.path), self.connected)

    def expect(self, container: str, secret: str, machine: str | None = None) -> None:
        """Expect one connection of a container; from another host, only of the given machine."""
        self._awaited.expect(container, secret, machine)

    def forget(self, container: str) -> None:
        """Expect a container no longer."""
        self._awaited.forget(container)

    def hang_up(self, container: str) -> None:
        """Close the link of a container that was lost with its machine; its later frames are ignored."""
        stream = self._served.get(container)
        if stream is not None:
            stream.abort()

    @property
    def awaited(self) -> int:
        """Number of expected containers that have not connected yet."""
        return len(self._awaited)

    async def connected(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, machine: str | None = None
    ) -> None:
        """Serve a connection; ``machine`` is the name in its certificate, None on the local socket."""
        stream: FrameStream[robot_link.FromContainer] = FrameStream(reader, writer, robot_link.FromContainer)
        self._streams.add(stream)
        try:
            first = await self._first(stream, machine)
            if isinstance(first, robot_link.ContainerFailed):
                self._failed(first)
            else:
                await self._serve(first, stream)
        except (PPaaSError, TimeoutError) as error:
            logger.warning("closed a robot link: %s", str(error) or "the container sent no first frame in time")
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
        while isinstance(first := await self._within(stream), robot_link.KernelsAwaited):
            self._check_origin(first, self._awaited.check(first.container, first.secret), machine)
            self._waits(first.container)
        if not isinstance(first, robot_link.Hello | robot_link.ContainerFailed):
            raise NotPermitted("the first frame on the robot link is not that of a container")
        self._check_origin(first, self._awaited.admit(first.container, first.secret), machine)
        return first

    async def _within(self, stream: FrameStream[robot_link.FromContainer]) -> robot_link.FromContainer | None:
        async with asyncio.timeout(self._hello_timeout):
            return await stream.receive()

    @staticmethod
    def _check_origin(first: _First, expected: str | None, machine: str | None) -> None:
        if machine not in (None, expected):
            raise NotPermitted(
                f"container {first.container!r} of machine {expected!r} connected from machine {machine!r}"
            )

    async def close(self) -> None:
        """Stop listening, and close all links."""
        if self._server is not None:
            self._server.close()
        await asyncio.gather(*(stream.close() for stream in self._streams))
        self.path.unlink(missing_ok=True)
