"""The receiving end of framing: bytes become frames where they arrive, and are handed over there or wake who waits.

``asyncio.StreamReader`` wakes its reader for the length and again for what follows, and copies twice; half of what a
frame takes from one process to another on the same machine.
"""

import asyncio
from collections import deque
from collections.abc import Callable
from typing import NamedTuple, cast

from ppaas.errors import MessageTooLarge

LENGTH = 4
"""Bytes that say how long a frame is."""

MAX_FRAME = 256 * 1024 * 1024
"""Bytes; the JSON of the largest map that fits the memory of a robot's operator is far below."""

MAX_HELD = 1 << 17
"""Bytes of whole frames that may wait to be taken before no more are read."""


class _DirectHandler(NamedTuple):
    take: Callable[[bytes], bool]
    over: asyncio.Future[None]


class FrameReceiver(asyncio.Protocol):
    """Takes the place of the protocol of a connection, and leaves to it all but what arrives.

    Parameters
    ----------
    reader, writer
        Of the connection; what the reader holds already is taken from it.
    most : int
        Bytes of a frame.
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
        """Return the next frame without its length, or None at the end of the connection, also where it breaks off.

        Raises
        ------
        MessageTooLarge
            It would have more bytes than a frame may have here.
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

    async def each(self, take: Callable[[bytes], bool]) -> None:
        """Hand each frame to ``take`` where it arrives, until that returns false or the connection ends.

        No task is woken for a frame, which saves a turn of the loop. What ``take`` raises is raised here; the rest
        is as for ``next``.
        """
        taking = self._taking = _DirectHandler(take, asyncio.get_running_loop().create_future())
        self._hand_over(taking)
        try:
            await taking.over
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
        except Exception as error:  # noqa: BLE001  # whoever waits for the end is told
            if not over.done():
                over.set_exception(error)
            return
        if not over.done() and (not more or self._ended or self._transport.is_closing()):
            over.set_result(None)

    def _pop(self) -> bytes:
        frame = self._frames.popleft()
        self._held -= len(frame)
        if self._paused and self._held <= MAX_HELD and not self._transport.is_closing():
            self._paused = False
            self._transport.resume_reading()
        return frame

    # -- what the connection tells -------------------------------------------------------------------------------------

    def data_received(self, data: bytes) -> None:
        """Cut what arrived into frames."""
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
        """Take no more."""
        self._end()
        return self._rest.eof_received() if isinstance(self._rest, asyncio.Protocol) else None

    def connection_lost(self, exc: Exception | None) -> None:
        """Take no more; nobody need be told why."""
        self._end()
        self._rest.connection_lost(exc)

    def pause_writing(self) -> None:
        """Tell who writes that the peer is behind."""
        self._rest.pause_writing()

    def resume_writing(self) -> None:
        """Tell who writes that the peer is behind no more."""
        self._rest.resume_writing()

    def _cut(self, held: bytes | bytearray) -> int:
        """Take the frames that are whole; return how many bytes these are."""
        begin = 0
        with memoryview(held) as view:
            while len(view) - begin >= LENGTH and self._fault is None:
                body = begin + LENGTH
                size = int.from_bytes(view[begin:body], "big")
                if size > self._most:
                    self._fault = MessageTooLarge(f"a frame of {size} bytes is over the limit of {self._most}")
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
    """Return what a reader can give without waiting."""
    reading = reader.read(1 << 30)
    try:
        reading.send(None)
    except StopIteration as held:
        return bytes(held.value)
    except ConnectionError:
        return b""
    reading.close()
    return b""
