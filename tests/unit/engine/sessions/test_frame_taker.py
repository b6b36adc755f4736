"""Frames of a client that wait: while types of ROS are read, or an operation awaits a permit."""

import asyncio
import threading

import pytest

from engine.protocols.session_frames import NumberedFrame
from engine.sessions import session
from engine.sessions.session import MAX_HELD, FrameTaker, PermitAwaited
from engine.sessions.unsettled import UnsettledFrames
from tests.support.waiting import patience

SUBSCRIBE = '{"op": "subscribe", "topic": "/map", "compression": "cbor-raw"}'
PLAN = "a path, please"


class Wire:
    """Wire whose operations are the texts of the frames."""

    incomplete = ()

    def receive(self, content: bytes) -> str:
        return content.decode()


class Types:
    """Types that are read when the test allows it, and the frames that were executed."""

    def __init__(self) -> None:
        self.may_end = threading.Event()
        self.read = False
        self.threads: list[int] = []
        self.taken: list[str] = []
        self.asked = 0
        self.permitted = False
        self.frames = FrameTaker(Wire(), self.execute, UnsettledFrames(), self.ask, self.release)  # type: ignore[arg-type]

    def release(self) -> None:
        self.frames.release()

    def execute(self, operation: str) -> None:
        if operation == PLAN and not self.permitted:
            raise PermitAwaited
        self.taken.append(operation)

    def ask(self) -> None:
        self.asked += 1

    def take(self, content: str) -> None:
        self.frames.take(NumberedFrame(1, content.encode()))

    @property
    def waiting(self) -> list[str]:
        """Frames that are not executed yet."""
        return [frame.content.decode() for frame in self.frames.waiting()]

    def read_types(self) -> None:
        self.threads.append(threading.get_ident())
        self.may_end.wait(5.0)
        self.read = True


@pytest.fixture
def types(monkeypatch: pytest.MonkeyPatch) -> Types:
    types = Types()
    monkeypatch.setattr(session, "read_types", types.read_types)
    monkeypatch.setattr(session, "are_types_read", lambda: types.read)
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


async def test_frames_wait_for_a_permit_and_after_it_for_types(types: Types) -> None:
    for frame in (PLAN, "between", SUBSCRIBE, "after"):
        types.take(frame)
    assert (types.taken, types.waiting, types.asked) == ([], [PLAN, "between", SUBSCRIBE, "after"], 1)
    types.permitted = True
    types.frames.resume()
    assert (types.taken, types.waiting) == ([PLAN, "between"], [SUBSCRIBE, "after"])
    types.taken.clear()
    await until_released(types)
    assert types.taken == [SUBSCRIBE, "after"] and types.waiting == []


async def test_a_frame_that_an_earlier_container_got_waits_for_no_types(types: Types) -> None:
    types.frames.replay(NumberedFrame(1, SUBSCRIBE.encode()))
    assert types.taken == [SUBSCRIBE] and not types.threads
