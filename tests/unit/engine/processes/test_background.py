"""Checks that repeat in the background."""

import asyncio
import logging

import pytest

from engine.processes.background import Background, repeat
from tests.support.waiting import patience


async def test_a_check_that_fails_is_repeated(caplog: pytest.LogCaptureFixture) -> None:
    outcomes, done = iter([True, False, False, True, False]), asyncio.Event()

    async def check() -> None:
        outcome = next(outcomes, None)
        if outcome is None:
            done.set()
        elif not outcome:
            raise RuntimeError("the disk is on fire")

    background = Background()
    with caplog.at_level(logging.DEBUG):
        background.run(repeat(check, 0.0))
        async with patience(10.0):
            await done.wait()
        await background.cancel()
    found = [record.levelname for record in caplog.records if record.exc_info]
    assert found == ["ERROR", "DEBUG", "ERROR"], "of failures in a row, the first is an error"


async def test_a_check_that_is_cancelled_ends() -> None:
    started = asyncio.Event()

    async def check() -> None:
        started.set()
        await asyncio.sleep(3600.0)

    task = asyncio.create_task(repeat(check, 3600.0))
    await started.wait()
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
