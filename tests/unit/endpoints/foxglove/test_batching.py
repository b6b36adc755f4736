"""Frames of a short time are sent by one write."""

import asyncio

from endpoints.foxglove import batching
from endpoints.foxglove.batching import BatchingConnection


class FakeConnection:
    """Connection that notes what each write consists of."""

    def __init__(self) -> None:
        self.ready = True
        self.writes: list[list[bytes]] = []

    def send_frames(self, frames: list[bytes]) -> None:
        self.writes.append(frames)


async def test_frames_wait_for_each_other() -> None:
    connection = FakeConnection()
    sink = BatchingConnection(connection)  # type: ignore[arg-type]
    for number in range(3):
        sink.send_frame(b"%d" % number)
    assert not connection.writes
    await asyncio.sleep(3 * batching.PERIOD)
    assert connection.writes == [[b"0", b"1", b"2"]]


async def test_many_bytes_are_sent_at_once() -> None:
    connection = FakeConnection()
    sink = BatchingConnection(connection)  # type: ignore[arg-type]
    sink.send_frame(b"a")
    sink.send_frame(bytes(batching.MAX_WAITING))
    assert [len(frames) for frames in connection.writes] == [2]
    await asyncio.sleep(3 * batching.PERIOD)
    assert len(connection.writes) == 1


async def test_nothing_is_sent_to_a_closed_connection() -> None:
    connection = FakeConnection()
    sink = BatchingConnection(connection)  # type: ignore[arg-type]
    sink.send_frame(b"a")
    connection.ready = False
    sink.flush()
    assert not connection.writes
