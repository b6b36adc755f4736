"""Pacing of frames, without sockets and with a clock that the test sets.

Members of the kind "one client freezes others": small frames of any operation, pings, fragments of one message, blocks
with many frames, frames that are costly to process, and many connections that do this together.
"""

import asyncio
import struct
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st
from websockets.frames import Frame, Opcode

from endpoints.http import frame_pacing
from endpoints.http.frame_pacing import (
    BACKLOG,
    BURST,
    FRAMES,
    OVERLOAD,
    STALL,
    TURN,
    FrameBudget,
    FramePacer,
    TurnQueue,
    frame_size,
    turns_of,
)
from ppaas.clock import Clock, ManualClock

WHOLE_TURN = 1.01 * TURN
"""Time of a frame after which the turn is over [s]."""


def frame(size: int, *, mask: bool = True) -> bytes:
    return Frame(Opcode.TEXT, b"x" * size).serialize(mask=mask)


class Peer:
    """Paced connection whose frames each take ``cost`` seconds."""

    def __init__(self, turns: TurnQueue, clock: ManualClock, cost: float = 0.0, cpu_clock: Clock = lambda: 0.0) -> None:
        self.fed: list[bytes] = []
        self.paused = False
        self.turns_over = 0
        self.floods = 0
        self._clock = clock
        self._cost = cost
        self.pacer = FramePacer(turns, self, clock, cpu_clock)

    def feed(self, piece: bytes) -> None:
        self.fed.append(piece)
        self._clock.advance(self._cost)

    def end_turn(self) -> None:
        self.turns_over += 1

    def flooded(self) -> None:
        self.floods += 1

    def pause_reading(self) -> None:
        self.paused = True

    def resume_reading(self) -> None:
        self.paused = False


@pytest.fixture
async def clock() -> ManualClock:
    return ManualClock()


@pytest.fixture
async def make(clock: ManualClock) -> Callable[[float], Peer]:
    turns = TurnQueue(asyncio.get_running_loop(), clock)
    return lambda cost: Peer(turns, clock, cost)


@pytest.mark.parametrize("size", [0, 1, 125, 126, 127, 65535, 65536, 70000])
@pytest.mark.parametrize("mask", [True, False])
def test_frame_size_is_that_of_the_whole_frame(size: int, mask: bool) -> None:
    data = frame(size, mask=mask)
    assert frame_size(b"???" + data + b"more", 3) == len(data)
    assert frame_size(data[:1], 0) == 0


@pytest.mark.parametrize("size", [126, 65536])
def test_the_size_of_a_frame_is_unknown_until_its_header_is_there(size: int) -> None:
    extended = 2 if size == 126 else 8
    data = frame(size)
    assert frame_size(data[: 1 + extended], 0) == 0
    assert frame_size(data[: 2 + extended], 0) == len(data)


def test_a_length_beyond_all_limits_is_left_to_the_parser() -> None:
    assert frame_size(b"\x81\xff" + struct.pack("!Q", 2**63 - 1), 0) > 2**62


@given(st.lists(st.sampled_from([0, 1, 5, 125, 126, 300, 70000]), max_size=8), st.data())
def test_data_is_fed_complete_and_in_order_however_it_arrives(sizes: list[int], data: st.DataObject) -> None:
    async def run() -> None:
        clock = ManualClock()
        peer = Peer(TurnQueue(asyncio.get_running_loop(), clock), clock)
        stream = b"".join(map(frame, sizes))
        cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=6)))
        for begin, end in zip([0, *cuts], [*cuts, len(stream)], strict=True):
            peer.pacer.receive(stream[begin:end])
        assert b"".join(peer.fed) == stream
        assert peer.pacer.unfinished == 0

    asyncio.run(run())


async def test_a_frame_alone_is_processed_at_once_and_reading_goes_on(make: Callable[[float], Peer]) -> None:
    peer = make(TURN / 2)
    peer.pacer.receive(frame(10))
    assert len(peer.fed) == 1 and not peer.paused and peer.turns_over == 1


async def test_a_block_of_many_frames_takes_many_turns_with_reading_paused(make: Callable[[float], Peer]) -> None:
    peer = make(TURN / 10)
    peer.pacer.receive(frame(10) * 35)
    assert len(peer.fed) == 10 and peer.paused
    await asyncio.sleep(0)
    assert len(peer.fed) == 20 and peer.paused
    for _ in range(3):
        await asyncio.sleep(0)
    assert len(peer.fed) == 35 and not peer.paused


async def test_others_are_served_at_once_while_a_block_waits(make: Callable[[float], Peer]) -> None:
    flood, robot = make(TURN / 2), make(TURN / 100)
    flood.pacer.receive(frame(10) * 1000)
    robot.pacer.receive(frame(100))
    assert len(robot.fed) == 1 and not robot.paused
    assert len(flood.fed) == 2


async def test_many_floods_share_the_time_of_one(make: Callable[[float], Peer]) -> None:
    floods = [make(WHOLE_TURN) for _ in range(5)]
    for flood in floods:
        flood.pacer.receive(frame(10) * 1000)
    before = sum(len(flood.fed) for flood in floods)
    for _ in range(10):
        await asyncio.sleep(0)
    assert sum(len(flood.fed) for flood in floods) - before == 10
    assert {len(flood.fed) for flood in floods} <= {2, 3}


async def test_data_that_arrives_although_reading_is_paused_is_kept_in_order(make: Callable[[float], Peer]) -> None:
    peer = make(WHOLE_TURN)
    first, second = frame(10) * 2, frame(20)
    peer.pacer.receive(first)
    peer.pacer.receive(second)
    assert peer.paused
    for _ in range(4):
        await asyncio.sleep(0)
    assert b"".join(peer.fed) == first + second


async def test_a_connection_over_its_budget_waits_before_its_next_turn(make: Callable[[float], Peer]) -> None:
    peer = make(BURST)  # one frame uses more than the budget in advance
    peer.pacer.receive(frame(10) * 3)
    fed = len(peer.fed)
    assert peer.paused and fed == 1
    for _ in range(5):
        await asyncio.sleep(0)
    assert len(peer.fed) == fed


def test_unused_budget_is_limited_to_a_burst() -> None:
    budget = FrameBudget()
    assert budget.charge(int(FRAMES * BURST), 0, 0.0, 1000.0) == pytest.approx(0.0)
    assert budget.charge(int(FRAMES), 0, 0.0, 1000.5) == pytest.approx(0.5)
    assert budget.charge(0, 0, 0.0, 1000.0 + 3 * BURST) < 0.0


@pytest.mark.parametrize("used", [(4000, 0, 0.0), (0, 128 << 20, 0.0), (0, 0, 0.5), (2000, 32 << 20, 0.125)])
def test_frames_bytes_and_time_use_one_budget(used: tuple[int, int, float]) -> None:
    assert FrameBudget().charge(*used, 0.0) == pytest.approx(1.0 - BURST)


def run(peer: Peer, clock: ManualClock, seconds: float, data: bytes) -> None:
    """Send blocks of data as fast as they are read, with a turn every 0.1 s."""
    until = clock.now + seconds
    while clock.now < until:
        if peer.paused:
            peer.pacer.take_turn()
        else:
            peer.pacer.receive(data)
        clock.advance(0.1)


async def test_a_connection_that_stays_over_its_budget_is_reported(
    make: Callable[[float], Peer], clock: ManualClock
) -> None:
    flood = frame(BACKLOG) * 10
    peer = make(0.5)
    run(peer, clock, OVERLOAD, flood)
    assert peer.floods == 0
    run(peer, clock, OVERLOAD, flood)
    assert peer.floods > 0


async def test_a_connection_within_its_budget_is_never_reported(
    make: Callable[[float], Peer], clock: ManualClock
) -> None:
    peer = make(0.04)
    run(peer, clock, 5 * OVERLOAD, frame(BACKLOG) * 10)
    assert peer.floods == 0


async def test_a_client_that_waits_for_answers_is_slowed_but_not_reported(
    make: Callable[[float], Peer], clock: ManualClock
) -> None:
    peer = make(2.0)
    run(peer, clock, 5 * OVERLOAD, frame(BACKLOG // 2))
    assert peer.floods == 0


async def test_a_connection_whose_frames_stall_the_loop_waits_long(clock: ManualClock) -> None:
    peer = Peer(TurnQueue(asyncio.get_running_loop(), clock), clock, 3.0 * STALL, clock)
    peer.pacer.receive(frame(10))
    assert not peer.paused, "the machine may have been busy"
    peer.pacer.receive(frame(10))
    assert peer.paused


async def test_a_connection_that_a_busy_machine_delays_does_not_wait(clock: ManualClock) -> None:
    peer = Peer(TurnQueue(asyncio.get_running_loop(), clock), clock, 3.0 * STALL)
    for _ in range(5):
        peer.pacer.receive(frame(10))
        clock.advance(1.0)
    assert not peer.paused


async def test_a_stopped_connection_drops_what_waits_and_what_follows(make: Callable[[float], Peer]) -> None:
    peer = make(WHOLE_TURN)
    peer.pacer.receive(frame(10) * 10)
    peer.pacer.stop()
    peer.pacer.receive(frame(10))
    for _ in range(3):
        await asyncio.sleep(0)
    assert len(peer.fed) == 1


def test_the_budget_is_far_above_a_robot_with_many_sensors() -> None:
    depth_images = 30 * 640 * 480 * 2 * 4 / 3
    used = 1000 / frame_pacing.FRAMES + depth_images / frame_pacing.BYTES + 0.1 / frame_pacing.BUSY
    assert used < 0.75


class Taker:
    """Takes turns of ``cost`` seconds, and waits for the next one as long as frames are left."""

    def __init__(self, queue: TurnQueue, clock: ManualClock, cost: float, frames: int) -> None:
        self.taken = 0
        self._queue = queue
        self._clock = clock
        self._cost = cost
        self._frames = frames

    def take_turn(self) -> None:
        self.taken += 1
        self._clock.advance(self._cost)
        if self.taken < self._frames:
            self._queue.add(self)


# Turns of connections: one per iteration of the loop, shared by those that wait.


async def test_short_turns_share_an_iteration_and_long_ones_take_one_each() -> None:
    clock = ManualClock()
    queue = TurnQueue(asyncio.get_running_loop(), clock)
    short = [Taker(queue, clock, TURN / 10, 1) for _ in range(5)]
    long = [Taker(queue, clock, 1.1 * TURN, 1) for _ in range(2)]
    for taker in (*short, *long):
        queue.add(taker)
    await asyncio.sleep(0)
    assert [taker.taken for taker in (*short, *long)] == [1, 1, 1, 1, 1, 1, 0]
    await asyncio.sleep(0)
    assert long[1].taken == 1 and not queue


async def test_takers_that_wait_again_come_after_the_others() -> None:
    clock = ManualClock()
    queue = TurnQueue(asyncio.get_running_loop(), clock)
    takers = [Taker(queue, clock, 1.1 * TURN, 3) for _ in range(3)]
    for taker in takers:
        queue.add(taker)
    for turns in range(1, 10):
        await asyncio.sleep(0)
        assert sum(taker.taken for taker in takers) == turns
        assert max(taker.taken for taker in takers) - min(taker.taken for taker in takers) <= 1
    assert not queue


async def test_a_taker_within_its_turn_is_not_run_again_in_the_same_iteration() -> None:
    clock = ManualClock()
    queue = TurnQueue(asyncio.get_running_loop(), clock)
    taker = Taker(queue, clock, 0.0, 5)
    queue.add(taker)
    await asyncio.sleep(0)
    assert taker.taken == 1


async def test_each_loop_has_one_queue() -> None:
    loop = asyncio.get_running_loop()
    assert turns_of(loop) is turns_of(loop)
