"""Holds a connection to the cloud for as long as the cloud lets it: sends, receives, and connects again."""

import asyncio
import logging
import math
from collections.abc import Callable, Iterator

from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosed

from ppaas.clock import monotonic
from ppaas.errors import Conflict, Idle, Unavailable
from ppaas.wire.refusals import error_of_close
from ppaas.wire.resumption import LEFT, ResumptionPoint
from robots.client.connection import Address, Link, open_socket, session_of
from robots.client.send_queue import Outbox

logger = logging.getLogger(__name__)

STEADY = 5.0
"""Seconds after which a connection counts as good: the waits before the next one begin small again."""


class ConnectionKeeper:
    """Keeps one WebSocket.

    Parameters
    ----------
    address : Address
        Of the WebSocket.
    link : Link
        Time-outs and sizes.
    outbox : Outbox
        What to send.
    reconnect_delays : callable
        Makes the seconds to wait before each attempt to connect again.
    greeting : callable
        Returns the frames with which each session begins.
    received : callable
        Given each frame that comes.
    lost : callable
        Called when a session begins in which the cloud knows nothing of the one before.
    """

    def __init__(
        self,
        address: Address,
        link: Link,
        outbox: Outbox,
        reconnect_delays: Callable[[], Iterator[float]],
        *,
        greeting: Callable[[], list[str]],
        received: Callable[[str | bytes], None],
        lost: Callable[[], None],
    ) -> None:
        self._address = address
        self._link = link
        self._outbox = outbox
        self._reconnect_delays = reconnect_delays
        self._greeting = greeting
        self._received = received
        self._lost = lost
        self._since = math.inf
        self._session = ""
        self._count = 0
        self.connected = asyncio.Event()
        self.connections = 0
        self.resumptions = 0

    async def run(self) -> None:
        """Keep the connection until this is cancelled.

        Raises
        ------
        PPaaSError
            What the cloud refuses with, unless it is ``Unavailable``: that is tried again.
        """
        delays = self._reconnect_delays()
        while True:
            try:
                await self._converse(await self._open())
            except Unavailable as error:
                logger.info("not connected: %s", error)
                if isinstance(error, Idle) and self._address.hold:
                    await self._outbox.filled()  # without anything to say, a container would be held for nothing
                    continue
            if self._was_steady():
                delays = self._reconnect_delays()
            await asyncio.sleep(next(delays))

    async def _open(self) -> ClientConnection:
        try:
            point = ResumptionPoint(self._session, self._count) if self._session else None
            return await open_socket(self._address.at(point), self._link)
        except Conflict as error:
            if not self.connections:
                raise
            raise Unavailable(f"the cloud may not have noticed yet that our old connection is dead: {error}") from error

    def _was_steady(self) -> bool:
        since, self._since = self._since, math.inf
        return monotonic() - since > STEADY

    async def _converse(self, socket: ClientConnection) -> None:
        """Send and receive until the connection ends; raise why it did."""
        self._find_session(socket)
        sender = asyncio.create_task(self._send(socket))
        try:
            async for frame in socket:
                self._count += 1
                self._received(frame)
        except ConnectionClosed:
            logger.debug("the connection broke with code %s", socket.close_code)
        finally:
            sender.cancel()
            await asyncio.gather(sender, return_exceptions=True)
            self.connected.clear()
            await socket.close(reason=LEFT)  # says something only where it is we who go
        raise error_of_close(socket.close_code, socket.close_reason or "")

    def _find_session(self, socket: ClientConnection) -> None:
        session, taken = session_of(socket)
        if taken is not None and session == self._session:
            self.resumptions += 1
            self._outbox.resume(taken)
        else:
            self._session, self._count = session, 0
            if self.connections:
                self._lost()
            self._outbox.begin(self._greeting())
        self.connected.set()
        self.connections += 1
        self._since = monotonic()

    async def _send(self, socket: ClientConnection) -> None:
        while True:
            await socket.send(await self._outbox.next())
            self._outbox.sent()
