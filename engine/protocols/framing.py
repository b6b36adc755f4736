"""Framing: typed messages over a byte stream, each a length of four bytes (big endian) and one MessagePack struct.

The same framing is used over Unix sockets on one machine and over TLS between machines. Back-pressure comes from the
stream: ``send`` waits while the peer reads slower than we write.

The receiver of frames is an ``asyncio.Protocol``. ``asyncio.StreamReader`` wakes its reader once for the length and
again for the body, and copies twice: half of the time that a frame takes between two processes of a machine.
"""

import asyncio
import contextlib
from collections import deque
from collections.abc import Callable
from typing import Any, Generic, NamedTuple, TypeVar, cast

import msgspec

from ppaas.errors import MalformedMessage, MessageTooLarge

LENGTH = 4
"""Size of the length before each frame [bytes]."""

MAX_FRAME = 256 * 1024 * 1024
"""Largest frame [bytes]; far above the JSON of the largest map that a client can hold in memory."""

MAX_HELD = 1 << 17
"""Bytes of complete frames in the queue above which reading pauses."""


# -- incoming bytes ----------------------------------------------------------------------------------------------------


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
    reading = reader.read(1 << 30)
    try:
        reading.send(None)
    except StopIteration as held:
        return bytes(held.value)
    except ConnectionError:
        return b""
    reading.close()
    return b""


# -- messages ----------------------------------------------------------------------------------------------------------

CLOSE_GRACE = 2.0
"""Time for the peer to read the remaining data of a closed stream before it is dropped [s]."""

In = TypeVar("In")

_encoder = msgspec.msgpack.Encoder()


def pack(message: msgspec.Struct) -> tuple[bytes, bytes]:
    """Return the frame of a message as length and body, without the copy that joining them would take."""
    body = _encoder.encode(message)
    return len(body).to_bytes(LENGTH, "big"), body


class FrameStream(Generic[In]):
    """One end of a connection.

    Parameters
    ----------
    reader, writer
        Streams of the connection.
    incoming : type
        Type, or union of tagged structs, of the messages that the peer sends.
    most : int
        Largest frame from the peer [bytes].
    """

    def __init__(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, incoming: Any, most: int = MAX_FRAME
    ) -> None:
        self._receiver = FrameReceiver(reader, writer, most)
        self._writer = writer
        self._decoder: msgspec.msgpack.Decoder[In] = msgspec.msgpack.Decoder(incoming)

    async def receive(self) -> In | None:
        """Return the next message, or None when the stream is closed or lost.

        Raises
        ------
        MessageTooLarge, MalformedMessage
            The peer violates the protocol; close the stream.
        """
        body = await self._receiver.next()
        return None if body is None else self._decode(body)

    async def each(self, take: Callable[[In], bool]) -> bool:
        """Call ``take`` with each message as it arrives, until it returns false or the stream ends.

        Raises the exceptions of ``receive`` and of ``take``.

        Returns
        -------
        bool
            Whether ``take`` returned false.
        """
        return await self._receiver.each(lambda body: take(self._decode(body)))

    def _decode(self, body: bytes) -> In:
        try:
            return self._decoder.decode(body)
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
            raise MalformedMessage(f"the frame is not a message of this link: {error}") from error

    def write(self, message: msgspec.Struct) -> None:
        """Queue a message without waiting. Does nothing on a closed stream."""
        self.write_packed(pack(message))

    def write_packed(self, frame: tuple[bytes, bytes]) -> None:
        """Queue a frame made by `pack`, which may be the same for several streams."""
        if not self._writer.is_closing():
            self._writer.writelines(frame)

    async def send(self, message: msgspec.Struct) -> None:
        """Queue a message, and wait while the peer is slow."""
        self.write(message)
        with contextlib.suppress(ConnectionError):
            await self._writer.drain()

    @property
    def waiting(self) -> int:
        """Size of the write buffer [bytes]."""
        return self._writer.transport.get_write_buffer_size()

    def abort(self) -> None:
        """Abort the connection without waiting for the peer."""
        self._writer.transport.abort()

    async def close(self) -> None:
        """Close the stream; abort it if the peer does not read the remaining data in time."""
        self._writer.close()
        # In a separate task: several callers may wait for the same close, and one may be cancelled.
        closed = asyncio.create_task(self._wait_closed())
        await asyncio.wait({closed}, timeout=CLOSE_GRACE)
        if not closed.done():
            self._writer.transport.abort()
        await closed

    async def _wait_closed(self) -> None:
        # A lost connection counts as closed.
        with contextlib.suppress(ConnectionError):
            await self._writer.wait_closed()
