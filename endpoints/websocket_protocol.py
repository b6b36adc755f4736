"""The WebSocket protocol of the server: uvicorn's, whose other end can also be asked whether it is still there."""

import asyncio
import secrets
from collections.abc import Awaitable, Callable
from typing import Any

from starlette.websockets import WebSocket
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import Frame
from websockets.http11 import Request

PROBE = "ppaas.probe"
"""Key of the scope's state under which the probe of a connection is found."""

ABORT_GRACE = 1.0
"""Seconds that a connection has to close after its other end stopped answering: what waits for it to be read would keep
it open for many minutes."""

Probe = Callable[[float], Awaitable[bool]]


class ProbedWebSocket(WebSocketsSansIOProtocol):
    """A connection that can be probed, and that is cut off when its other end is gone."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._probes: dict[bytes, asyncio.Future[None]] = {}

    def handle_connect(self, event: Request) -> None:
        """Begin to serve a request, which may be answered with a refusal."""
        super().handle_connect(event)
        if self.response.status_code == 101:
            self.scope["state"][PROBE] = self.probe

    async def probe(self, timeout: float) -> bool:
        """Ping the other end; tell whether it answered in so many seconds."""
        if self.disconnected or self.close_sent or self.transport.is_closing():
            return False
        payload = b"probe" + secrets.token_bytes(4)
        answered = self._probes[payload] = self.loop.create_future()
        self.conn.send_ping(payload)
        self.transport.write(b"".join(self.conn.data_to_send()))
        try:
            async with asyncio.timeout(timeout):
                await answered
        except TimeoutError:
            return False
        finally:
            del self._probes[payload]
        return True

    def handle_pong(self, event: Frame) -> None:
        """Take the answer to a probe; uvicorn takes those to its own pings."""
        answered = self._probes.get(bytes(event.data))
        if answered is None:
            super().handle_pong(event)
        elif not answered.done():
            answered.set_result(None)

    def keepalive_timeout(self) -> None:
        """Give a connection up whose other end did not answer a ping in time."""
        super().keepalive_timeout()
        self.loop.call_later(ABORT_GRACE, self.transport.abort)


def probe_of(socket: WebSocket) -> Probe:
    """Return the probe of a WebSocket; where the server cannot ask, the other end counts as there."""
    probe: Probe | None = socket.scope.get("state", {}).get(PROBE)
    return probe or _believed


async def _believed(_timeout: float) -> bool:
    return True
