"""Checks that repeat in the background, and processes that are stopped by a signal."""

import asyncio
import logging
import os
import signal

import pytest

from engine.processes.background import Background, repeat, run_unless_stopped, stop_on_signals
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


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=lambda number: number.name)
async def test_a_signal_ends_the_work_and_is_named_in_the_log(
    number: signal.Signals, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    before = signal.getsignal(number)
    try:
        stop = stop_on_signals()
        asyncio.get_running_loop().call_soon(os.kill, os.getpid(), number)
        assert await run_unless_stopped(stop, asyncio.sleep(60.0, "done")) is None
        assert f"it got {number.name}" in caplog.text
    finally:
        asyncio.get_running_loop().remove_signal_handler(number)
        signal.signal(number, before)


async def test_work_that_is_done_first_has_its_result() -> None:
    assert await run_unless_stopped(asyncio.Event(), asyncio.sleep(0.0, "done")) == "done"
