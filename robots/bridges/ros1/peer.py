"""One end of a TCPROS connection: frames in, and frames out through a bounded queue."""

import asyncio
import socket
import struct
from collections import deque
from collections.abc import Callable

from ppaas.errors import MessageTooLarge
from ppaas.wire.ros.tcpros import MAX_HEADER, FrameReader, framed, pack_header

HEADER_TIMEOUT = 10.0
"""Time limit for the header of the other side [s]."""

KEEPALIVE = (5, 2, 3)
"""Silence before the first probe [s], time between probes [s], and their number: 11 s until a dead peer is noticed."""

WRITE_BUFFER, UNSENT = 64 << 10, 16 << 10
"""Bytes that wait in this process and in the kernel; the queue, which may drop messages, holds the rest [bytes]."""

BACKOFF = 4
"""Doublings of the time between two attempts of TCP to send, from 0.2 s on, after which a peer counts as stalled."""

DEPTH = 10
"""Length of a queue, where nothing else is set."""


class Peer(asyncio.Protocol):
    """Connection to another node.

    Parameters
    ----------
    received : callable
        Called with this peer and each frame; the first one is the header of the other side.

    Attributes
    ----------
    received : callable
        As above; it is replaced when the header has been read.
    node, topic : str
        Name of the node, and topic or service of the connection; empty until its header has been read.
    limit : int
        Largest frame that is read [bytes].
    lost : Future of None
        Set when the connection is lost.
    """

    def __init__(self, received: "Callable[[Peer, bytes], None]") -> None:
        self.received = received
        self.node = self.topic = ""
        self.limit = MAX_HEADER
        self.bytes_carried = self.frames_carried = 0
        loop = asyncio.get_running_loop()
        self.lost: asyncio.Future[None] = loop.create_future()
        self._reader = FrameReader()
        self._queue: deque[bytes] = deque(maxlen=DEPTH)
        self._paused = False
        self._transport: asyncio.Transport | None = None
        self._timer = loop.call_later(HEADER_TIMEOUT, self.abort)

    def greeted(self, limit: int, depth: int = DEPTH) -> None:
        """Go on from the header to messages of at most ``limit`` bytes, and a queue of ``depth`` messages."""
        self._timer.cancel()
        self.limit = limit
        self._queue = deque(self._queue, maxlen=max(depth, 1))

    def send_header(self, fields: dict[str, str]) -> None:
        """Send a header."""
        self._write(framed(pack_header(fields)))

    def send(self, data: bytes) -> None:
        """Send a message with its length in front; if the other side does not read, the oldest one is dropped."""
        if self._paused:
            self._queue.append(data)
        else:
            self._write(data)

    @property
    def closing(self) -> bool:
        """True if the connection is closed, or about to be."""
        return self._transport is None or self._transport.is_closing()

    @property
    def stalled(self) -> bool:
        """True if TCP has nearly given up sending unconfirmed bytes again, as after an outage; known on Linux only."""
        if self.closing or self._transport is None or not hasattr(socket, "TCP_INFO"):
            return False
        info = self._transport.get_extra_info("socket").getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, 8)
        return bool(info[4] >= BACKOFF)  # tcpi_backoff of `struct tcp_info`

    def reset(self) -> None:
        """Close the connection by a reset of TCP: the other side notices it at once, and reconnects."""
        if self._transport is not None:
            at_once = struct.pack("ii", 1, 0)
            self._transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, at_once)
        self.abort()

    def close(self) -> None:
        """Close the connection once its write buffer is empty."""
        self._timer.cancel()
        if self._transport is not None:
            self._transport.close()

    def abort(self) -> None:
        """Close the connection at once."""
        self._timer.cancel()
        if self._transport is not None:
            self._transport.abort()

    def _write(self, data: bytes) -> None:
        if self._transport is None or self._transport.is_closing():
            return
        self.bytes_carried += len(data)
        self.frames_carried += 1
        self._transport.write(data)

    # -- callbacks of asyncio ------------------------------------------------------------------------------------------

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Take the connection."""
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        transport.set_write_buffer_limits(high=WRITE_BUFFER)
        connected = transport.get_extra_info("socket")
        connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connected.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        if hasattr(socket, "TCP_NOTSENT_LOWAT"):
            connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, UNSENT)
        if hasattr(socket, "TCP_KEEPIDLE"):  # Linux
            for option, value in zip(
                (socket.TCP_KEEPIDLE, socket.TCP_KEEPINTVL, socket.TCP_KEEPCNT), KEEPALIVE, strict=True
            ):
                connected.setsockopt(socket.IPPROTO_TCP, option, value)

    def data_received(self, data: bytes) -> None:
        """Hand on the frames that are complete."""
        self._reader.feed(data)
        try:
            while not self.closing and (frame := self._reader.take(self.limit)) is not None:
                self.bytes_carried += len(frame)
                self.frames_carried += 1
                self.received(self, frame)
        except MessageTooLarge:
            self.abort()

    def pause_writing(self) -> None:
        """Queue what follows."""
        self._paused = True

    def resume_writing(self) -> None:
        """Send what was queued."""
        self._paused = False
        while self._queue and not self._paused:
            self._write(self._queue.popleft())

    def connection_lost(self, error: Exception | None) -> None:
        """Set ``lost``."""
        self._timer.cancel()
        self._queue.clear()
        if not self.lost.done():
            self.lost.set_result(None)
