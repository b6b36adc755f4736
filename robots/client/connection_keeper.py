"""Reconnecting WebSocket: sends and receives frames, and reconnects until the cloud refuses."""

import asyncio
import logging
import math
from collections.abc import Callable, Iterator

from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosed

from ppaas.clock import monotonic
from ppaas.errors import Conflict, Idle, PPaaSError, Starting, Unavailable
from ppaas.wire.refusals import error_of_close
from ppaas.wire.resumption import LEFT, ResumptionPoint
from robots.client.connection import Address, ConnectionOptions, nearer_endpoint, open_socket, session_of
from robots.client.send_queue import SendQueue

logger = logging.getLogger(__name__)

STARTING_DELAY = 1.0
"""Time until the next attempt if the cloud is starting [s]; it then keeps each attempt waiting for some seconds."""

STABLE_AFTER = 5.0
"""Age at which a connection counts as stable [s]; reconnect delays then start from the shortest again."""


class ConnectionKeeper:
    """Maintains one WebSocket to the cloud.

    Parameters
    ----------
    address : Address
        URL and headers of the WebSocket.
    link : ConnectionOptions
        Time-outs and sizes.
    queue : SendQueue
        Frames to send.
    reconnect_delays : callable
        Returns an iterator of the delays between attempts to connect [s].
    greeting : callable
        Returns the frames that begin each new session.
    received : callable
        Called with each frame received.
    lost : callable
        Called when the cloud begins a new session although there was one before.
    """

    def __init__(
        self,
        address: Address,
        link: ConnectionOptions,
        queue: SendQueue,
        reconnect_delays: Callable[[], Iterator[float]],
        *,
        greeting: Callable[[], list[str]],
        received: Callable[[str | bytes], None],
        lost: Callable[[], None],
    ) -> None:
        self._address = address
        self._link = link
        self._queue = queue
        self._reconnect_delays = reconnect_delays
        self._greeting = greeting
        self._received = received
        self._lost = lost
        self._since = math.inf
        self._starting: Starting | None = None
        self._refused_at = -math.inf
        self._session = ""
        self._count = 0
        self.connected = asyncio.Event()
        self.connections = 0
        self.resumptions = 0

    async def run(self) -> None:
        """Maintain the connection until cancelled.

        Raises
        ------
        PPaaSError
            The reason why the cloud refused the client. ``Unavailable`` is retried instead.
        """
        delays = self._reconnect_delays()
        while True:
            try:
                await self._exchange_frames(await self._open())
            except Starting as error:
                self._note_start(error)
                await asyncio.sleep(STARTING_DELAY)
                continue
            except Unavailable as error:
                logger.info("not connected: %s", error)
                self._starting = None
                if isinstance(error, Idle) and self._address.hold:
                    await self._queue.filled()  # a connection without messages would hold a container for nothing
                    continue
            if self._was_stable():
                delays = self._reconnect_delays()
            await asyncio.sleep(next(delays))

    def _note_start(self, error: Starting) -> None:
        """Note that the cloud is starting, and say so whenever that has changed."""
        if str(error) != str(self._starting):
            logger.warning("waiting: %s", error)
        self._starting = error
        self._refused_at = monotonic()

    async def wait_connected(self, runner: asyncio.Task[None], timeout: float, check: Callable[[], None]) -> None:
        """Wait for the first connection, as long as the cloud is starting, and then for a limited time.

        Parameters
        ----------
        runner : Task
            Task that executes `run`.
        timeout : float
            Time limit, over all attempts [s]; it begins again each time that the cloud says that it is starting.
        check : callable
            Called after the wait; raises if the runner has failed.

        Raises
        ------
        Unavailable
            There was no connection in time; the text says what the cloud was doing, if it is known.
        """
        waiting, began = asyncio.create_task(self.connected.wait()), monotonic()
        try:
            left = timeout
            while left > 0.0 and not (runner.done() or waiting.done()):
                await asyncio.wait({runner, waiting}, timeout=left, return_when=asyncio.FIRST_COMPLETED)
                left = max(began, self._refused_at) + timeout - monotonic()
        finally:
            waiting.cancel()
        check()
        if not self.connected.is_set():
            last = f", {self._starting}" if self._starting is not None else "; check that it runs"
            raise Unavailable(f"no connection to the cloud within {timeout:g} s{last}")

    async def _open(self) -> ClientConnection:
        try:
            return await self._open_preferred()
        except Conflict as error:
            if not self.connections:
                raise
            raise Unavailable(f"the cloud may still hold the previous connection of this client: {error}") from error

    async def _open_preferred(self) -> ClientConnection:
        """Connect to the nearer endpoint if the cloud has named one, and to the given address if that fails."""
        try:
            return await self._open_once()
        except PPaaSError as error:
            if not self._address.go_back():
                raise
            logger.info("the nearer endpoint did not take the connection: %s", error)
            return await self._open_once()

    async def _open_once(self) -> ClientConnection:
        point = ResumptionPoint(self._session, self._count) if self._session else None
        return await open_socket(self._address.at(point), self._address.headers, self._link)

    def _was_stable(self) -> bool:
        since, self._since = self._since, math.inf  # counted once: an attempt that fails next is not stable
        return monotonic() - since > STABLE_AFTER

    async def _exchange_frames(self, socket: ClientConnection) -> None:
        """Send and receive until the connection ends; raise the reason."""
        self._find_session(socket)
        sender = asyncio.create_task(self._send(socket))
        try:
            async for frame in socket:
                self._count += 1
                self._received(frame)
        except ConnectionClosed:
            logger.debug("the connection was lost with code %s", socket.close_code)
        finally:
            sender.cancel()
            await asyncio.gather(sender, return_exceptions=True)
            self.connected.clear()
            await socket.close(reason=LEFT)  # the reason is sent only if this side closes first
        raise error_of_close(socket.close_code, socket.close_reason or "")

    def _find_session(self, socket: ClientConnection) -> None:
        if nearer := nearer_endpoint(socket):
            self._address.prefer(nearer)
        session, taken = session_of(socket)
        if taken is not None and session == self._session:
            self.resumptions += 1
            self._queue.resume(taken)
        else:
            self._session, self._count = session, 0
            if self.connections:
                self._lost()
            self._queue.begin(self._greeting())
        self.connected.set()
        self.connections += 1
        self._since = monotonic()

    async def _send(self, socket: ClientConnection) -> None:
        while True:
            await socket.send(await self._queue.next())
            self._queue.sent()
