"""SIGTERM to an agent."""

import asyncio
import os
import signal

from engine.agent.agent import until_told
from tests.support.waiting import until


async def test_sigterm_gives_up_what_is_inside() -> None:
    told, done = asyncio.Event(), False
    with until_told(told):
        os.kill(os.getpid(), signal.SIGTERM)
        await asyncio.sleep(60.0)
        done = True
    assert told.is_set()
    assert not done


async def test_sigterm_after_it_disturbs_nothing_and_is_not_lost() -> None:
    told = asyncio.Event()
    with until_told(told):
        pass
    os.kill(os.getpid(), signal.SIGTERM)
    await until(told.is_set)
    await asyncio.sleep(0.0)
