"""Frames of a client that wait while types of ROS are read."""

import asyncio
import threading

import pytest

from engine.protocols.session_frames import NumberedFrame
from engine.sessions import held_frames
from engine.sessions.held_frames import MAX_HELD, HeldFrames
from tests.support.waiting import patience

SUBSCRIBE = '{"op": "subscribe", "topic": "/map", "compression": "cbor-raw"}'


class Types:
    """Types that are read when the test allows it, and the frames that were passed on."""

    def __init__(self) -> None:
        self.may_end = threading.Event()
        self.read = False
        self.threads: list[int] = []
        self.taken: list[str] = []
        self.frames = HeldFrames(lambda frame: self.taken.append(frame.content.decode()))

    def take(self, content: str) -> None:
        self.frames.take(NumberedFrame(1, content.encode()))

    def read_types(self) -> None:
        self.threads.append(threading.get_ident())
        self.may_end.wait(5.0)
        self.read = True


@pytest.fixture
def types(monkeypatch: pytest.MonkeyPatch) -> Types:
    types = Types()
    monkeypatch.setattr(held_frames, "read_types", types.read_types)
    monkeypatch.setattr(held_frames, "are_types_read", lambda: types.read)
    return types


async def until_released(types: Types) -> None:
    types.may_end.set()
    async with patience(5.0):
        while not types.taken:
            await asyncio.sleep(0.001)


async def test_frames_after_the_first_raw_subscription_wait_in_their_order(types: Types) -> None:
    frames = ["before", SUBSCRIBE, "after", SUBSCRIBE]
    for frame in frames:
        types.take(frame)
    assert types.taken == ["before"]
    types.taken.clear()
    await until_released(types)
    assert types.taken == frames[1:]
    assert types.threads and threading.get_ident() not in types.threads, "the event loop read them"


async def test_nothing_waits_once_types_are_read(types: Types) -> None:
    types.read = True
    types.take(SUBSCRIBE)
    assert types.taken == [SUBSCRIBE]
    assert not types.threads


async def test_large_frames_are_not_searched(types: Types) -> None:
    large = "x" * 10000 + SUBSCRIBE
    types.take(large)
    assert types.taken == [large]


async def test_no_more_waits_than_a_client_may_send_in_that_time(types: Types) -> None:
    types.take(SUBSCRIBE)
    types.take("x" * MAX_HELD)
    assert len(types.taken) == 2
    types.may_end.set()


async def test_frames_of_a_client_that_leaves_are_passed_on_at_once(types: Types) -> None:
    types.take(SUBSCRIBE)
    types.take("goal")
    types.frames.release()
    assert types.taken == [SUBSCRIBE, "goal"]
    types.may_end.set()
