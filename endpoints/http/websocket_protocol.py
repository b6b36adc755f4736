"""The WebSocket protocol of the server: uvicorn's, whose frames can be taken and sent where they arrive.

ASGI wakes a task for each frame, pauses reading for it, and wakes another task for the answer. A robot that waits for
a path waits for all of that. So who serves a WebSocket may ask for its connection, and take frames from it directly.
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
"""Key of the scope's state under which the connection is found."""

ABORT_GRACE = 1.0
"""Seconds that a connection has to close after its other end stopped answering: what waits for it to be read would keep
it open for many minutes."""

Probe = Callable[[float], Awaitable[bool]]
Taker = Callable[[str | None], None]
"""Takes the text of a frame, or None for one of bytes. It may not raise."""


class DirectWebSocket(WebSocketsSansIOProtocol):
    """A connection whose frames are handed over as they arrive, that can be probed, and is cut off when it is dead."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._probes: dict[bytes, asyncio.Future[None]] = {}
        self._taker: Taker | None = None
        self._on_ready: Callable[[], None] | None = None
        self._on_round_trip: Callable[[float], None] | None = None

    # -- frames --------------------------------------------------------------------------------------------------------

    def hand_to(self, taker: Taker | None, on_ready: Callable[[], None] | None = None) -> None:
        """Hand each frame to ``taker`` from now on; with None, leave them to ``receive`` of ASGI again.

        Parameters
        ----------
        taker : callable, optional
        on_ready : callable, optional
            Called when frames can be sent again after the other end read too slowly.
        """
        self._taker = taker
        self._on_ready = on_ready

    @property
    def ready(self) -> bool:
        """Whether a frame can be sent at once."""
        open_ = self.conn.state is State.OPEN and not (self.disconnected or self.close_sent)
        return open_ and self.writable.is_set() and not self.transport.is_closing()

    def send_frame(self, frame: bytes) -> None:
        """Send a text, which is UTF-8; only while ``ready``."""
        self.conn.send_text(frame)
        self.transport.write(b"".join(self.conn.data_to_send()))

    def resume_writing(self) -> None:
        """Learn that the other end has read what was sent."""
        super().resume_writing()
        if self._on_ready is not None:
            self._on_ready()

    def send_receive_event_to_app(self) -> None:
        """Hand over a message that is whole; what is no text is left to uvicorn, which closes for it."""
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

    # -- whether the other end is there --------------------------------------------------------------------------------

    def handle_connect(self, event: Request) -> None:
        """Begin to serve a request, which may be answered with a refusal."""
        super().handle_connect(event)
        if self.response.status_code == 101:
            self.scope["state"][CONNECTION] = self

    def tell_round_trips(self, told: Callable[[float], None]) -> None:
        """Have ``told`` called with the round trip of each of uvicorn's pings that is answered [s]."""
        self._on_round_trip = told

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
            awaited = bytes(event.data) == self.pending_ping_payload
            super().handle_pong(event)
            if awaited and self._on_round_trip is not None:
                self._on_round_trip(self.last_ping_rtt)
        elif not answered.done():
            answered.set_result(None)

    def keepalive_timeout(self) -> None:
        """Give a connection up whose other end did not answer a ping in time."""
        super().keepalive_timeout()
        self.loop.call_later(ABORT_GRACE, self.transport.abort)


def connection_of(socket: WebSocket) -> DirectWebSocket:
    """Return the connection of a WebSocket that this protocol serves."""
    connection: DirectWebSocket = socket.scope["state"][CONNECTION]
    return connection
