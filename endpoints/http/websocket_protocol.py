"""WebSocket protocol of uvicorn with direct access to frames, bypassing ASGI.

ASGI wakes a task per frame, pauses reading meanwhile, and wakes another task for the response. A robot that requests a
path waits for all of this. The application may therefore get the connection and receive and send frames directly.
"""

import asyncio
import secrets
from collections.abc import Awaitable, Callable
from typing import Any

from starlette.websockets import WebSocket
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import Frame
from websockets.http11 import Request
from websockets.protocol import State

CONNECTION = "ppaas.connection"
"""Key of the connection in the state of the ASGI scope."""

ABORT_GRACE = 1.0
"""Time to close a connection whose peer stopped answering [s]; then it is aborted, because unsent data would keep it
open for many minutes."""

Probe = Callable[[float], Awaitable[bool]]
"""Called with a time limit [s]; returns whether the peer answered a ping in time."""

Taker = Callable[[str | None], None]
"""Called with the text of a frame, or None for a binary frame. It must not raise."""


class DirectWebSocket(WebSocketsSansIOProtocol):
    """Connection that passes frames on as they arrive, can be probed, and is aborted when its peer is dead."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._probes: dict[bytes, asyncio.Future[None]] = {}
        self._taker: Taker | None = None
        self._on_ready: Callable[[], None] | None = None
        self._on_round_trip: Callable[[float], None] | None = None

    # -- frames --------------------------------------------------------------------------------------------------------

    def hand_to(self, taker: Taker | None, on_ready: Callable[[], None] | None = None) -> None:
        """Pass each frame to ``taker`` from now on; with None, pass frames to ``receive`` of ASGI again.

        Parameters
        ----------
        taker : callable, optional
            Called with each frame.
        on_ready : callable, optional
            Called when frames can be sent again after the peer read too slowly.
        """
        self._taker = taker
        self._on_ready = on_ready

    @property
    def ready(self) -> bool:
        """Whether a frame can be sent now."""
        open_ = self.conn.state is State.OPEN and not (self.disconnected or self.close_sent)
        return open_ and self.writable.is_set() and not self.transport.is_closing()

    def send_frame(self, frame: bytes) -> None:
        """Send a text frame, encoded as UTF-8; call it only while ``ready``."""
        self.conn.send_text(frame)
        self.transport.write(b"".join(self.conn.data_to_send()))

    def resume_writing(self) -> None:
        """Handle that the peer has read the buffered data."""
        super().resume_writing()
        if self._on_ready is not None:
            self._on_ready()

    def send_receive_event_to_app(self) -> None:
        """Pass a complete message on; invalid UTF-8 is left to uvicorn, which closes the connection."""
        if self._taker is None or self.close_sent:
            super().send_receive_event_to_app()
            return
        text = None
        if self.curr_msg_data_type == "text":
            try:
                text = b"".join(self.frames).decode()
            except UnicodeDecodeError:
                super().send_receive_event_to_app()
                return
        self.frames = []
        self._taker(text)

    # -- liveness of the peer ------------------------------------------------------------------------------------------

    def handle_connect(self, event: Request) -> None:
        """Handle the opening handshake, which may be rejected."""
        super().handle_connect(event)
        if self.response.status_code == 101:
            self.scope["state"][CONNECTION] = self

    def on_round_trip(self, callback: Callable[[float], None]) -> None:
        """Register a callback, called with the round trip of each answered ping of uvicorn [s]."""
        self._on_round_trip = callback

    async def probe(self, timeout: float) -> bool:
        """Ping the peer; return whether it answered within ``timeout`` seconds."""
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
        """Handle a pong to a probe; uvicorn handles pongs to its own pings."""
        answered = self._probes.get(bytes(event.data))
        if answered is None:
            awaited = bytes(event.data) == self.pending_ping_payload
            super().handle_pong(event)
            if awaited and self._on_round_trip is not None:
                self._on_round_trip(self.last_ping_rtt)
        elif not answered.done():
            answered.set_result(None)

    def keepalive_timeout(self) -> None:
        """Close the connection because its peer did not answer a ping in time."""
        super().keepalive_timeout()
        self.loop.call_later(ABORT_GRACE, self.transport.abort)


def connection_of(socket: WebSocket) -> DirectWebSocket:
    """Return the connection of a WebSocket served by this protocol."""
    connection: DirectWebSocket = socket.scope["state"][CONNECTION]
    return connection
