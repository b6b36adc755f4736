"""Typed frames over a byte stream: a length of four bytes, then one MessagePack struct.

The same framing runs over Unix sockets on one machine and, between machines, over TLS. Back-pressure is the stream's
own: ``send`` waits while the peer reads slower than we write.
"""

import asyncio
import contextlib
from collections.abc import Callable
from typing import Any, Generic, TypeVar

import msgspec

from engine.protocols.frame_receiver import LENGTH, MAX_FRAME, FrameReceiver
from ppaas.errors import MalformedMessage

CLOSE_GRACE = 2.0
"""Seconds that a peer has to take what was written before it was closed; then it is lost."""

In = TypeVar("In")

_encoder = msgspec.msgpack.Encoder()


def pack(message: msgspec.Struct) -> tuple[bytes, bytes]:
    """Return the frame of a message in two parts, so that a large one is not copied to be joined."""
    body = _encoder.encode(message)
    return len(body).to_bytes(LENGTH, "big"), body


class FrameStream(Generic[In]):
    """One end of a connection.

    Parameters
    ----------
    reader, writer
        Of the connection.
    incoming : type
        The type, or union of tagged structs, that the peer sends.
    most : int
        Bytes of a frame from the peer.
    """

    def __init__(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, incoming: Any, most: int = MAX_FRAME
    ) -> None:
        self._receiver = FrameReceiver(reader, writer, most)
        self._writer = writer
        self._decoder: msgspec.msgpack.Decoder[In] = msgspec.msgpack.Decoder(incoming)

    async def receive(self) -> In | None:
        """Return the next frame, or None at the end of the stream, also where it breaks off.

        Raises
        ------
        MessageTooLarge, MalformedMessage
            The peer does not speak this protocol; close the stream.
        """
        body = await self._receiver.next()
        return None if body is None else self._decode(body)

    async def each(self, take: Callable[[In], bool]) -> None:
        """Hand each frame to ``take`` where it arrives, until that returns false or the stream ends.

        Raises as ``receive`` does, and what ``take`` raises.
        """
        await self._receiver.each(lambda body: take(self._decode(body)))

    def _decode(self, body: bytes) -> In:
        try:
            return self._decoder.decode(body)
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
            raise MalformedMessage(f"not a frame of this link: {error}") from error

    def write(self, message: msgspec.Struct) -> None:
        """Queue a frame without waiting; nothing happens on a closed stream."""
        if not self._writer.is_closing():
            self._writer.writelines(pack(message))

    async def send(self, message: msgspec.Struct) -> None:
        """Queue a frame and wait while the peer is behind."""
        self.write(message)
        with contextlib.suppress(ConnectionError):
            await self._writer.drain()

    @property
    def waiting(self) -> int:
        """Bytes written that the peer has not yet taken."""
        return self._writer.transport.get_write_buffer_size()

    def abort(self) -> None:
        """Break the connection off, whatever the peer does."""
        self._writer.transport.abort()

    async def close(self) -> None:
        """Close both directions, by force where the peer does not take what was written."""
        self._writer.close()
        # In a task of its own: several may wait for the same end, and none may take it from the others.
        closed = asyncio.create_task(self._wait_closed())
        await asyncio.wait({closed}, timeout=CLOSE_GRACE)
        if not closed.done():
            self._writer.transport.abort()
        await closed

    async def _wait_closed(self) -> None:
        # A peer that is gone already is closed as well; whoever asked may have given up waiting to hear it.
        with contextlib.suppress(ConnectionError):
            await self._writer.wait_closed()
