"""Turns of connections: one per iteration of the loop, shared by those that wait."""

import asyncio

from endpoints.http.frame_turns import TURN, TurnQueue, turns_of
from ppaas.clock import ManualClock


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
