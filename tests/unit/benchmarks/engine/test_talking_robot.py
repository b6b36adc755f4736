"""Received positions are matched with published ones."""

import asyncio

from benchmarks.engine.talking_robot import STEP, ReceivedPositions


async def test_a_position_is_found_whether_it_came_before_or_comes_later() -> None:
    heard = ReceivedPositions()
    heard.note(1.0, 2.0)
    at = await heard.of(2.0)
    assert at == heard.times[0][0]
    later = asyncio.create_task(heard.of(3.0))
    await asyncio.sleep(0)
    heard.note(2.0 + STEP)
    heard.note(3.0)
    assert await later == heard.times[-1][0]


async def test_the_wait_for_a_lost_position_has_a_time_limit() -> None:
    heard = ReceivedPositions()
    heard.note(1.0 + STEP)
    assert await heard.of(1.0) is None
