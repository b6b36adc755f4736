"""Frames over a real socket pair, and bytes split into frames."""

import asyncio
import socket

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.protocols import robot_link
from engine.protocols.framing import LENGTH, MAX_FRAME, MAX_HELD, FrameReceiver, FrameStream, pack
from ppaas.errors import InvalidInput, MalformedMessage, MessageTooLarge
from tests.support.waiting import patience

Streams = tuple[FrameStream[robot_link.FromContainer], FrameStream[robot_link.ToContainer], asyncio.StreamWriter]


async def pair() -> Streams:
    ours, theirs = socket.socketpair()
    reader, writer = await asyncio.open_connection(sock=ours)
    far_reader, far_writer = await asyncio.open_connection(sock=theirs)
    near: FrameStream[robot_link.FromContainer] = FrameStream(reader, writer, robot_link.FromContainer)
    far: FrameStream[robot_link.ToContainer] = FrameStream(far_reader, far_writer, robot_link.ToContainer)
    return near, far, far_writer


@given(st.lists(st.tuples(st.text(), st.binary(max_size=5000)), max_size=20))
def test_messages_arrive_complete_and_in_order(messages: list[tuple[str, bytes]]) -> None:
    async def check() -> None:
        near, far, _ = await pair()
        for topic, payload in messages:
            await far.send(robot_link.Published(topic, payload))
        await far.close()
        for topic, payload in messages:
            assert await near.receive() == robot_link.Published(topic, payload)
        assert await near.receive() is None
        await near.close()

    asyncio.run(check())


async def test_a_stream_cut_in_the_middle_of_a_frame_ends() -> None:
    near, far, writer = await pair()
    writer.write(b"".join(pack(robot_link.Ack(1)))[:-1])
    await far.close()
    assert await near.receive() is None
    await near.close()


@pytest.mark.parametrize("body", [b"", b"\x00", b"\xc1" * 40, b"\x81\xa4type\xa5other", b"\xff" * 8])
async def test_an_invalid_frame_is_malformed(body: bytes) -> None:
    near, far, writer = await pair()
    writer.write(len(body).to_bytes(4, "big") + body)
    with pytest.raises(MalformedMessage):
        await near.receive()
    await far.close()
    await near.close()


async def test_a_giant_frame_is_refused_before_it_is_read() -> None:
    near, far, writer = await pair()
    writer.write((MAX_FRAME + 1).to_bytes(4, "big"))
    with pytest.raises(MessageTooLarge):
        await near.receive()
    await far.close()
    await near.close()


async def test_sending_waits_for_a_reader_that_is_behind() -> None:
    near, far, _ = await pair()
    payload = bytes(1 << 20)
    sender = asyncio.create_task(_send_many(far, payload, 64))
    done, _ = await asyncio.wait({sender}, timeout=0.2)
    assert not done
    assert far.waiting < 4 * len(payload)
    received = 0
    while await near.receive() is not None:
        received += 1
    await sender
    assert received == 64
    await near.close()


async def _send_many(stream: FrameStream[robot_link.ToContainer], payload: bytes, count: int) -> None:
    for _ in range(count):
        await stream.send(robot_link.Published("map", payload))
    await stream.close()


@pytest.mark.parametrize(
    "body",
    [
        pack(robot_link.Ack(1))[1].replace(b"ack", b"\xff\xfe\xfd"),
        b"\x83\xa4type\xa3ack\xa8sequence\x01\xa1z" + b"\x91" * 100_000 + b"\xc0",
    ],
    ids=["invalid text", "deep nesting"],
)
async def test_a_frame_that_breaks_the_decoder_is_malformed_too(body: bytes) -> None:
    near, far, writer = await pair()
    writer.write(len(body).to_bytes(4, "big") + body)
    with pytest.raises(MalformedMessage):
        await near.receive()
    await far.close()
    await near.close()


async def test_closing_has_a_time_limit_if_the_peer_does_not_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.protocols.framing.CLOSE_GRACE", 0.05)
    near, far, _ = await pair()
    far.write(robot_link.Published("map", bytes(64 << 20)))
    async with patience(10):
        await asyncio.gather(far.close(), far.close())
    await near.close()


async def test_closing_delivers_written_data_to_a_peer_that_reads() -> None:
    near, far, _ = await pair()
    far.write(robot_link.Published("map", bytes(16 << 20)))
    closing = asyncio.create_task(far.close())
    published = await near.receive()
    assert isinstance(published, robot_link.Published)
    assert len(published.payload) == 16 << 20
    await closing
    await near.close()


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
