"""Framing: typed messages over a byte stream, each a length of four bytes (big endian) and one MessagePack struct.

The same framing is used over Unix sockets on one machine and over TLS between machines. Back-pressure comes from the
stream: ``send`` waits while the peer reads slower than we write.
"""

import asyncio
import contextlib
from collections.abc import Callable
from typing import Any, Generic, TypeVar

import msgspec

from engine.protocols.frame_receiver import LENGTH, MAX_FRAME, FrameReceiver
from ppaas.errors import MalformedMessage

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
