"""WebSocket protocol of uvicorn with direct access to frames, bypassing ASGI.

ASGI wakes a task per frame, pauses reading meanwhile, and wakes another task for the response. A robot that requests a
path waits for all of this. The application may therefore get the connection and receive and send frames directly.

Frames are processed in fair turns; see `endpoints.http.frame_pacing`.
"""

import asyncio
import contextlib
import logging
import secrets
from collections.abc import Awaitable, Callable, Iterable
from typing import Any, Literal, Protocol

from starlette.websockets import WebSocket, WebSocketDisconnect
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import CloseCode, Frame
from websockets.http11 import Request
from websockets.protocol import State

from endpoints.http.frame_pacing import FramePacer, turns_of
from endpoints.http.problems import RefusalLog
from ppaas.errors import NotAuthenticated, NotPermitted, PPaaSError
from ppaas.wire.binary.binary_frame import BinaryFrame

logger = logging.getLogger(__name__)

CONNECTION = "ppaas.connection"
"""Key of the connection in the state of the ASGI scope."""

ABORT_GRACE = 1.0
"""Time to close a connection whose peer stopped answering [s]; then it is aborted, because unsent data would keep it
open for many minutes."""

QUIET = 0.05
"""Time without data after which a connection is closed whose peer was in the wrong [s]."""

MESSAGE_TIMEOUT = 60.0
"""Time limit from the first byte of a message to its last [s]."""

Probe = Callable[[float], Awaitable[bool]]
"""Called with a time limit [s]; returns whether the peer answered a ping in time."""


class Taker(Protocol):
    """Takes messages. It must not raise."""

    def __call__(self, content: bytes, *, binary: bool) -> None:
        """Take a binary message, or a text message in valid UTF-8."""
        ...


refusals = RefusalLog(logger)


class DirectWebSocket(WebSocketsSansIOProtocol):
    """Connection that passes frames on as they arrive, can be probed, and is aborted when its peer is dead.

    Attributes
    ----------
    name : str
        Name of the client in the log.
    on_lost : callable, optional
        Called when the connection has ended.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.name = "WebSocket"
        self._probes: dict[bytes, asyncio.Future[None]] = {}
        self._taker: Taker | None = None
        self._on_ready: Callable[[], None] | None = None
        self._on_round_trip: Callable[[float], None] | None = None
        self.on_lost: Callable[[], None] | None = None
        self._pacer = FramePacer(turns_of(self.loop), self)
        self._parts: bytearray | None = None
        self._pong = b""
        self._dropped = True
        self._message_timer: asyncio.TimerHandle | None = None

    # -- received data -------------------------------------------------------------------------------------------------

    def data_received(self, data: bytes) -> None:
        """Handle received data: the request of the handshake, then frames."""
        if self.handshake_initiated:
            self._dropped = True
            self._pacer.receive(data)
        else:
            super().data_received(data)

    def feed(self, piece: bytes) -> None:
        """Process a frame, or a part of one."""
        super().data_received(piece)

    def pause_reading(self) -> None:
        """Stop reading from the peer."""
        self.transport.pause_reading()

    def resume_reading(self) -> None:
        """Read from the peer again, unless ASGI has received no message since its last."""
        if not self.read_paused:
            self.transport.resume_reading()

    def end_turn(self) -> None:
        """Send the pong of the turn, and watch whether the last message is completed in time."""
        if self._pong:
            self._send_pong()
        if self._pacer.unfinished or self._parts is not None:
            if self._message_timer is None:
                self._message_timer = self.loop.call_later(MESSAGE_TIMEOUT, self._unfinished)
        elif self._message_timer is not None:
            self._message_timer.cancel()
            self._message_timer = None

    def _unfinished(self) -> None:
        self.end(CloseCode.POLICY_VIOLATION, f"a message was not completed within {MESSAGE_TIMEOUT:g} s")

    def flooded(self) -> None:
        """Close the connection, which exceeds its budget."""
        self.end(CloseCode.POLICY_VIOLATION, "too many frames: send fewer, or wait for answers")

    def handle_ping(self) -> None:
        """Answer a ping at the end of the turn; of several in one turn, the last is answered (RFC 6455, 5.5.3)."""
        self._pong = b"".join(self.conn.data_to_send())

    def _send_pong(self) -> None:
        """Send the pong, unless the peer does not read: its pings must not fill the memory."""
        pong, self._pong = self._pong, b""
        if pong and self.writable.is_set():
            self.transport.write(pong)

    # -- frames --------------------------------------------------------------------------------------------------------

    def hand_to(self, taker: Taker | None, on_ready: Callable[[], None] | None = None) -> None:
        """Pass each message to ``taker`` from now on; with None, pass messages to ``receive`` of ASGI again.

        Parameters
        ----------
        taker : callable, optional
            Called with each message.
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
        """Send a text frame, encoded as UTF-8, or a binary frame; call it only while ``ready``."""
        self.send_frames((frame,))

    def send_frames(self, frames: Iterable[bytes]) -> None:
        """Send frames by one write; call it only while ``ready``."""
        for frame in frames:
            if isinstance(frame, BinaryFrame):
                self.conn.send_binary(frame)
            else:
                self.conn.send_text(frame)
        self.transport.write(b"".join(self.conn.data_to_send()))

    def resume_writing(self) -> None:
        """Handle that the peer has read the buffered data."""
        super().resume_writing()
        if self._on_ready is not None:
            self._on_ready()

    def handle_text(self, event: Frame) -> None:
        """Handle the first frame of a text message."""
        self._begin("text", event)

    def handle_bytes(self, event: Frame) -> None:
        """Handle the first frame of a binary message."""
        self._begin("bytes", event)

    def _begin(self, kind: Literal["text", "bytes"], event: Frame) -> None:
        self.curr_msg_data_type = kind
        if event.fin:
            self._complete(bytes(event.data))
        else:
            self._parts = bytearray(event.data)

    def handle_cont(self, event: Frame) -> None:
        """Handle a further frame of a message; the frames are joined as they arrive, since there may be millions."""
        parts = self._parts
        assert parts is not None  # websockets refuses a continuation of no message
        parts += event.data
        if event.fin:
            self._parts = None
            self._complete(bytes(parts))

    def _complete(self, message: bytes) -> None:
        if self.close_sent:
            return
        binary = self.curr_msg_data_type == "bytes"
        if not (binary or is_utf8(message)):
            self.end(CloseCode.INVALID_DATA, "a text frame must be UTF-8")
        elif self._taker is not None:
            self._taker(message, binary=binary)
        else:
            self.frames = [message]
            self.send_receive_event_to_app()

    # -- ends ----------------------------------------------------------------------------------------------------------

    def end(self, code: CloseCode, reason: str) -> None:
        """Close the connection because of what the peer did, and log it."""
        if self.close_sent or self.disconnected:
            return
        self.conn.fail(code, reason)
        self.handle_parser_exception()

    def handle_parser_exception(self) -> None:
        """Close the connection because of an invalid frame, with the close frame of the parser.

        The transport is closed once no more data arrives, and what arrives is dropped: closed with unread data, it
        would be reset, and the peer would not see the reason.
        """
        closing = self.conn.close_sent
        code, reason = (closing.code, closing.reason) if closing is not None else (CloseCode.ABNORMAL_CLOSURE, "")
        self.warn(f"closed with code {int(code)}: {reason}")
        self._pacer.stop()
        self.queue.put_nowait({"type": "websocket.disconnect", "code": code, "reason": reason})
        self.transport.write(b"".join(self.conn.data_to_send()))
        self.close_sent = True
        self.transport.resume_reading()
        self._close_when_quiet(int(ABORT_GRACE / QUIET))

    def _close_when_quiet(self, periods: int) -> None:
        if self._dropped and periods:
            self._dropped = False
            self.close_timer = self.loop.call_later(QUIET, self._close_when_quiet, periods - 1)
        else:
            self.transport.close()
            self.loop.call_later(ABORT_GRACE, self.transport.abort)

    def handle_close(self, event: Frame) -> None:
        """Handle the close frame of the peer."""
        self._send_pong()
        super().handle_close(event)

    def connection_lost(self, exc: Exception | None) -> None:
        """Handle the end of the connection."""
        self._pacer.stop()
        if self._message_timer is not None:
            self._message_timer.cancel()
        if self.on_lost is not None:
            self.on_lost()
        super().connection_lost(exc)

    def warn(self, text: str) -> None:
        """Log what the peer did wrong, with its name and address; a few lines a second for one address."""
        refusals.add(self.client[0] if self.client is not None else "unknown address", f"{self.name}: {text}")

    async def send(self, message: Any) -> None:
        """Send an ASGI message; with the whole response of a refusal, the handshake is complete.

        uvicorn notes this for an accepted handshake only, and logs each refusal as an error.
        """
        await super().send(message)
        if message["type"] == "websocket.http.response.body" and not message.get("more_body", False):
            self.handshake_complete = True

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


def is_utf8(text: bytes) -> bool:
    """Return whether a text is UTF-8."""
    if not text.isascii():  # most messages are, and this makes no copy
        try:
            text.decode()
        except UnicodeDecodeError:
            return False
    return True


def connection_of(socket: WebSocket) -> DirectWebSocket:
    """Return the connection of a WebSocket served by this protocol."""
    connection: DirectWebSocket = socket.scope["state"][CONNECTION]
    return connection


# Closing of WebSockets by the cloud, with the reason.

CLOSED_BY_CLOUD = 1011
"""Close code: the session is over."""

NO_RIGHT = 1008
"""Close code: the client lost a right, such as its token (policy violation, RFC 6455, section 7.4.1)."""

CLOSE_TIMEOUT = 2.0
"""Time limit of the closing handshake [s]."""

MAX_REASON = 123
"""Largest reason in a close frame [bytes] (RFC 6455, section 5.5)."""


async def close_with(socket: WebSocket, error: PPaaSError, code: int | None = None, *, last: bytes = b"") -> None:
    """Close a WebSocket because of an error; a client that does not take part is left.

    Parameters
    ----------
    socket : WebSocket
        Accepted WebSocket.
    error : PPaaSError
        Reason.
    code : int, optional
        Close code; default: `NO_RIGHT` for a lost right, `CLOSED_BY_CLOUD` for all else.
    last : bytes
        Text that is sent before it; empty for none.
    """
    if code is None:
        code = NO_RIGHT if isinstance(error, NotAuthenticated | NotPermitted) else CLOSED_BY_CLOUD
    reason = f"{error.slug}: {error.public}".encode()[:MAX_REASON].decode(errors="ignore")
    with contextlib.suppress(TimeoutError, WebSocketDisconnect):
        async with asyncio.timeout(CLOSE_TIMEOUT):
            if last:
                await socket.send_text(last.decode())
            await socket.close(code, reason)
