"""Splitting bytes of a real socket pair into frames."""

import asyncio
import socket

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.protocols.framing import LENGTH, MAX_FRAME, MAX_HELD, FrameReceiver
from ppaas.errors import InvalidInput, MessageTooLarge
from tests.support.waiting import patience


def framed(body: bytes) -> bytes:
    return len(body).to_bytes(LENGTH, "big") + body


async def connection() -> tuple[asyncio.StreamReader, asyncio.StreamWriter, asyncio.StreamWriter]:
    ours, theirs = socket.socketpair()
    reader, writer = await asyncio.open_connection(sock=ours)
    _, far = await asyncio.open_connection(sock=theirs)
    return reader, writer, far


@given(st.lists(st.binary(max_size=300), max_size=8), st.lists(st.integers(0, 2000), max_size=8))
def test_frames_are_complete_for_any_split_of_the_bytes(bodies: list[bytes], cuts: list[int]) -> None:
    async def check() -> None:
        reader, writer, far = await connection()
        receiver = FrameReceiver(reader, writer)
        sent, at = b"".join(map(framed, bodies)), 0
        for cut in (*sorted(cuts), len(sent)):
            far.write(sent[at:cut])
            await far.drain()
            await asyncio.sleep(0)
            at = max(at, cut)
        far.close()
        assert [await receiver.next() for _ in bodies] == bodies
        assert await receiver.next() is None
        writer.close()

    asyncio.run(check())


async def test_data_in_the_buffer_of_the_reader_is_not_lost() -> None:
    reader, writer, far = await connection()
    whole, half = framed(b"first"), framed(b"second")
    far.write(b"!" + whole + half[:6])
    assert await reader.readexactly(1) == b"!", "so the rest is buffered too"
    receiver = FrameReceiver(reader, writer)
    assert await receiver.next() == b"first"
    far.write(half[6:])
    assert await receiver.next() == b"second"
    far.close()
    writer.close()


async def test_reading_pauses_while_the_queue_is_full() -> None:
    reader, writer, far = await connection()
    receiver = FrameReceiver(reader, writer)
    body = bytes(MAX_HELD // 2)
    for _ in range(64):
        far.write(framed(body))
    draining = asyncio.create_task(far.drain())
    assert not (await asyncio.wait({draining}, timeout=0.1))[0]
    for _ in range(64):
        assert await receiver.next() == body
    await draining
    far.close()
    writer.close()


async def test_a_waiting_reader_is_woken_at_the_end() -> None:
    reader, writer, far = await connection()
    receiver = FrameReceiver(reader, writer)
    waiting = asyncio.create_task(receiver.next())
    far.close()
    async with patience(10):
        assert await waiting is None
    writer.close()


async def test_frames_are_handed_over_as_they_arrive_until_take_returns_false() -> None:
    reader, writer, far = await connection()
    receiver = FrameReceiver(reader, writer)
    taken: list[bytes] = []

    def take(frame: bytes) -> bool:
        taken.append(frame)
        return frame != b"enough"

    far.write(framed(b"one") + framed(b"two") + framed(b"enough") + framed(b"more"))
    async with patience(10):
        await receiver.each(take)
        assert taken == [b"one", b"two", b"enough"]
        assert await receiver.next() == b"more"
    far.close()
    async with patience(10):
        await receiver.each(take)
    assert taken[3:] == [], "the end of the connection is the end"
    writer.close()


async def test_queued_frames_are_handed_over_too() -> None:
    reader, writer, far = await connection()
    receiver = FrameReceiver(reader, writer)
    far.write(framed(b"first") + framed(b"waits"))
    async with patience(10):
        assert await receiver.next() == b"first"
        await receiver.each(lambda frame: frame != b"waits")
    far.close()
    writer.close()


async def test_an_exception_of_take_is_raised_in_each() -> None:
    reader, writer, far = await connection()
    receiver = FrameReceiver(reader, writer)

    def take(frame: bytes) -> bool:
        raise InvalidInput(frame.decode())

    far.write(framed(b"not so"))
    async with patience(10):
        with pytest.raises(InvalidInput, match="not so"):
            await receiver.each(take)
    far.close()
    writer.close()


async def test_a_frame_too_large_is_reported_after_the_frames_before_it() -> None:
    reader, writer, far = await connection()
    receiver = FrameReceiver(reader, writer)
    taken: list[bytes] = []

    def take(frame: bytes) -> bool:
        taken.append(frame)
        return True

    far.write(framed(b"good") + (MAX_FRAME + 1).to_bytes(LENGTH, "big"))
    async with patience(10):
        with pytest.raises(MessageTooLarge):
            await receiver.each(take)
    assert taken == [b"good"]
    far.close()
    writer.close()
