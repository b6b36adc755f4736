"""Received positions are matched with published ones."""

import asyncio

from benchmarks.engine.talking_robot import STEP, ReceivedPositions


async def test_a_position_received_earlier_or_later_is_found() -> None:
    received = ReceivedPositions()
    received.note(1.0, 2.0)
    at = await received.of(2.0)
    assert at == received.times[0][0]
    later = asyncio.create_task(received.of(3.0))
    await asyncio.sleep(0)
    received.note(2.0 + STEP)
    received.note(3.0)
    assert await later == received.times[-1][0]


async def test_the_wait_for_a_lost_position_has_a_time_limit() -> None:
    received = ReceivedPositions()
    received.note(1.0 + STEP)
    assert await received.of(1.0) is None
