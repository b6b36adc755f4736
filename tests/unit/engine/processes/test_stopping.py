"""A process that is stopped by a signal."""

import asyncio
import logging
import os
import signal

import pytest

from engine.processes.background import run_unless_stopped, stop_on_signals


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
