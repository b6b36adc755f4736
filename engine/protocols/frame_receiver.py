"""Receiver of frames: an ``asyncio.Protocol`` that splits incoming bytes into frames.

``asyncio.StreamReader`` wakes its reader once for the length and again for the body, and copies twice. That is half of
the time that a frame takes between two processes of the same machine.
"""

import asyncio
from collections import deque
from collections.abc import Callable
from typing import NamedTuple, cast

from ppaas.errors import MessageTooLarge

LENGTH = 4
"""Size of the length before each frame [bytes]."""

MAX_FRAME = 256 * 1024 * 1024
"""Largest frame [bytes]; far above the JSON of the largest map that a client can hold in memory."""

MAX_HELD = 1 << 17
"""Bytes of complete frames in the queue above which reading pauses."""


class _DirectHandler(NamedTuple):
    take: Callable[[bytes], bool]
    over: asyncio.Future[bool]


class FrameReceiver(asyncio.Protocol):
    """Replaces the protocol of a connection for incoming data, and forwards all other events to it.

    Parameters
    ----------
    reader, writer
        Streams of the connection; data that the reader has buffered is taken over.
    most : int
        Largest frame [bytes].
    """

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, most: int = MAX_FRAME) -> None:
        self._most = most
        self._transport = cast(asyncio.Transport, writer.transport)
        self._rest = self._transport.get_protocol()
        self._buffer = bytearray()
        self._frames: deque[bytes] = deque()
        self._held = 0
        self._paused = False
        self._ended = False
        self._fault: MessageTooLarge | None = None
        self._waiter: asyncio.Future[None] | None = None
        self._taking: _DirectHandler | None = None
        self._transport.set_protocol(self)
        self.data_received(_held_by(reader))
        self._ended = reader.at_eof()

    async def next(self) -> bytes | None:
        """Return the next frame without its length, or None when the connection is closed or lost.

        Raises
        ------
        MessageTooLarge
            The frame is larger than the limit.
        """
        while not self._frames:
            if self._fault is not None:
                raise self._fault
            if self._ended or self._transport.is_closing():
                return None
            self._waiter = asyncio.get_running_loop().create_future()
            try:
                await self._waiter
            finally:
                self._waiter = None
        return self._pop()

    async def each(self, take: Callable[[bytes], bool]) -> bool:
        """Call ``take`` with each frame as it arrives, until it returns false or the connection ends.

        No task is woken for a frame, which saves a turn of the loop. Raises the exceptions of ``take`` and of ``next``.

        Returns
        -------
        bool
            Whether ``take`` returned false.
        """
        taking = self._taking = _DirectHandler(take, asyncio.get_running_loop().create_future())
        self._hand_over(taking)
        try:
            return await taking.over
        finally:
            self._taking = None

    def _hand_over(self, taking: _DirectHandler) -> None:
        take, over = taking
        try:
            more = True
            while more and self._frames and not over.done():
                more = take(self._pop())
            if self._fault is not None and more:
                raise self._fault
        except Exception as error:  # noqa: BLE001  # raised in the task that waits in each()
            if not over.done():
                over.set_exception(error)
            return
        if not over.done() and (not more or self._ended or self._transport.is_closing()):
            over.set_result(not more)

    def _pop(self) -> bytes:
        frame = self._frames.popleft()
        self._held -= len(frame)
        if self._paused and self._held <= MAX_HELD and not self._transport.is_closing():
            self._paused = False
            self._transport.resume_reading()
        return frame

    # -- callbacks of the connection -----------------------------------------------------------------------------------

    def data_received(self, data: bytes) -> None:
        """Split incoming data into frames."""
        if self._buffer:
            self._buffer += data
            del self._buffer[: self._cut(self._buffer)]
        else:
            self._buffer += data[self._cut(data) :]
        if (self._fault is not None or self._held > MAX_HELD) and not (self._paused or self._transport.is_closing()):
            self._paused = True
            self._transport.pause_reading()
        if self._frames or self._fault is not None:
            self._wake()

    def eof_received(self) -> bool | None:
        """Stop receiving at the end of the stream."""
        self._end()
        return self._rest.eof_received() if isinstance(self._rest, asyncio.Protocol) else None

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop receiving when the connection is lost."""
        self._end()
        self._rest.connection_lost(exc)

    def pause_writing(self) -> None:
        """Forward to the writer: the peer is slow."""
        self._rest.pause_writing()

    def resume_writing(self) -> None:
        """Forward to the writer: the peer has caught up."""
        self._rest.resume_writing()

    def _cut(self, held: bytes | bytearray) -> int:
        """Queue the complete frames; return their total size [bytes]."""
        begin = 0
        with memoryview(held) as view:
            while len(view) - begin >= LENGTH and self._fault is None:
                body = begin + LENGTH
                size = int.from_bytes(view[begin:body], "big")
                if size > self._most:
                    self._fault = MessageTooLarge(f"a frame of {size} bytes exceeds the limit of {self._most} bytes")
                elif len(view) < body + size:
                    break
                else:
                    self._frames.append(bytes(view[body : body + size]))
                    self._held += size
                    begin = body + size
        return begin

    def _end(self) -> None:
        self._ended = True
        self._wake()

    def _wake(self) -> None:
        if self._waiter is not None and not self._waiter.done():
            self._waiter.set_result(None)
        if self._taking is not None:
            self._hand_over(self._taking)


def _held_by(reader: asyncio.StreamReader) -> bytes:
    """Return the buffered data of a reader."""
    reading = reader.read(1 << 30)
    try:
        reading.send(None)
    except StopIteration as held:
        return bytes(held.value)
    except ConnectionError:
        return b""
    reading.close()
    return b""
