"""Connections by TLS, bounded in time and number before their handshake is complete.

A server of asyncio makes the protocol of a connection when its handshake is complete. Until then it would not be
counted.
"""

import asyncio
import logging
import socket
import ssl
from collections.abc import Callable

from endpoints.http.connection_table import ConnectionTable

logger = logging.getLogger(__name__)

HANDSHAKE_SECONDS = 10.0
"""Time limit of the handshake [s]."""

PAUSE = 0.1
"""Pause after a connection could not be accepted, for example because too many files are open [s]."""


class TlsListener:
    """Accepts connections and completes their handshakes.

    Parameters
    ----------
    listener : socket
        Listening socket.
    context : SSLContext
        Context of the server.
    table : ConnectionTable
        Table of the connections of the server.
    served : callable
        Makes the protocol of a connection whose handshake is complete.
    """

    def __init__(
        self,
        listener: socket.socket,
        context: ssl.SSLContext,
        table: ConnectionTable,
        served: Callable[[], asyncio.Protocol],
    ) -> None:
        self._listener = listener
        self._context = context
        self._table = table
        self._served = served
        self._handshakes: set[_Handshake] = set()

    async def run(self) -> None:
        """Accept connections until cancelled; then end those whose handshake is not complete."""
        loop = asyncio.get_running_loop()
        self._listener.setblocking(False)
        try:
            while True:
                try:
                    accepted, peer = await loop.sock_accept(self._listener)
                except OSError as error:
                    logger.warning("a connection could not be accepted: %s", error)
                    await asyncio.sleep(PAUSE)
                    continue
                self._begin(accepted, str(peer[0]))
        finally:
            for handshake in tuple(self._handshakes):
                handshake.make_room()

    def _begin(self, accepted: socket.socket, host: str) -> None:
        handshake = _Handshake(accepted)
        if not self._table.admit(handshake, host):
            accepted.close()
            return
        self._handshakes.add(handshake)
        handshake.task = asyncio.get_running_loop().create_task(self._complete(handshake))

    async def _complete(self, handshake: "_Handshake") -> None:
        try:
            await asyncio.get_running_loop().connect_accepted_socket(
                lambda: _Starter(self._served, lambda: self._table.leave(handshake)),
                handshake.socket,
                ssl=self._context,
                ssl_handshake_timeout=HANDSHAKE_SECONDS,
            )
        except OSError as error:
            logger.debug("a TLS handshake failed: %s", error)
        finally:
            self._table.leave(handshake)
            self._handshakes.discard(handshake)


class _Handshake:
    """Connection whose handshake is not complete."""

    def __init__(self, accepted: socket.socket) -> None:
        self.socket = accepted
        self.task: asyncio.Task[None] | None = None

    def make_room(self) -> None:
        """Close the connection."""
        if self.task is not None:
            self.task.cancel()


class _Starter(asyncio.Protocol):
    """Protocol that is replaced by the one of the server when the handshake is complete."""

    def __init__(self, served: Callable[[], asyncio.Protocol], complete: Callable[[], None]) -> None:
        self._served = served
        self._complete = complete

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Handle the end of the handshake."""
        self._complete()
        protocol = self._served()
        transport.set_protocol(protocol)
        protocol.connection_made(transport)
