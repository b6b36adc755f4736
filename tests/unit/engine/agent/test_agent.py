"""SIGTERM to an agent."""

import asyncio
import os
import signal

from engine.agent.agent import until_terminated
from tests.support.waiting import until


async def test_sigterm_cancels_the_block() -> None:
    stopped, done = asyncio.Event(), False
    with until_terminated(stopped):
        os.kill(os.getpid(), signal.SIGTERM)
        await asyncio.sleep(60.0)
        done = True
    assert stopped.is_set()
    assert not done


async def test_sigterm_after_the_block_still_sets_the_event() -> None:
    stopped = asyncio.Event()
    with until_terminated(stopped):
        pass
    os.kill(os.getpid(), signal.SIGTERM)
    await until(stopped.is_set)
    await asyncio.sleep(0.0)
