"""Frames of a client that wait while types of ROS are read."""

import asyncio
import threading

import pytest

from endpoints.rosbridge import held_frames
from endpoints.rosbridge.held_frames import MAX_HELD, HeldFrames

SUBSCRIBE = '{"op": "subscribe", "topic": "/map", "compression": "cbor-raw"}'


class Types:
    """Types that are read when the test allows it, and the frames that were passed on."""

    def __init__(self) -> None:
        self.may_end = threading.Event()
        self.read = False
        self.threads: list[int] = []
        self.taken: list[str | bytes] = []
        self.frames = HeldFrames(self.taken.append)

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
    async with asyncio.timeout(5.0):
        while not types.taken:
            await asyncio.sleep(0.001)


@pytest.mark.parametrize("first", [SUBSCRIBE, SUBSCRIBE.encode()])
async def test_frames_after_the_first_raw_subscription_wait_in_their_order(types: Types, first: str | bytes) -> None:
    frames = ["before", first, "after", SUBSCRIBE]
    for frame in frames:
        types.frames.take(frame)
    assert types.taken == ["before"]
    types.taken.clear()
    await until_released(types)
    assert types.taken == frames[1:]
    assert types.threads and threading.get_ident() not in types.threads, "the event loop read them"


async def test_nothing_waits_once_types_are_read(types: Types) -> None:
    types.read = True
    types.frames.take(SUBSCRIBE)
    assert types.taken == [SUBSCRIBE]
    assert not types.threads


async def test_large_frames_are_not_searched(types: Types) -> None:
    large = "x" * 10000 + SUBSCRIBE
    types.frames.take(large)
    assert types.taken == [large]


async def test_no_more_waits_than_a_client_may_send_in_that_time(types: Types) -> None:
    types.frames.take(SUBSCRIBE)
    types.frames.take(b"x" * MAX_HELD)
    assert len(types.taken) == 2
    types.may_end.set()


async def test_frames_of_a_client_that_leaves_are_passed_on_at_once(types: Types) -> None:
    types.frames.take(SUBSCRIBE)
    types.frames.take("goal")
    types.frames.release()
    assert types.taken == [SUBSCRIBE, "goal"]
    types.may_end.set()
