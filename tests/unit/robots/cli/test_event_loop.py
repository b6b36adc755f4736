"""SIGTERM ends a command cleanly, as Ctrl-C does."""

import asyncio
import signal
import threading

import pytest
import uvloop

from robots.cli import event_loop
from robots.cli.event_loop import Terminated

FACTORIES = [None, uvloop.new_event_loop]


@pytest.mark.parametrize("factory", FACTORIES)
def test_run_returns_the_result_of_the_coroutine(factory) -> None:
    assert event_loop.run(asyncio.sleep(0.0, "done"), factory) == "done"


@pytest.mark.parametrize("factory", FACTORIES)
def test_sigterm_cancels_the_coroutine_and_raises_terminated(factory) -> None:
    ended = []

    async def work() -> None:
        asyncio.get_running_loop().call_later(0.01, signal.raise_signal, signal.SIGTERM)
        try:
            await asyncio.sleep(30.0)
        finally:
            await asyncio.sleep(0.01)
            ended.append(True)

    before = signal.getsignal(signal.SIGTERM)
    with pytest.raises(Terminated):
        event_loop.run(work(), factory)
    assert ended == [True]
    assert signal.getsignal(signal.SIGTERM) == before


def test_cancellation_without_a_signal_is_not_terminated() -> None:
    async def work() -> None:
        raise asyncio.CancelledError

    with pytest.raises(asyncio.CancelledError):
        event_loop.run(work())


def test_run_works_in_a_thread() -> None:
    done = []
    thread = threading.Thread(target=lambda: done.append(event_loop.run(asyncio.sleep(0.0, "done"))))
    thread.start()
    thread.join()
    assert done == ["done"]


def test_sigterm_raises_terminated_without_a_loop() -> None:
    before = signal.getsignal(signal.SIGTERM)
    with pytest.raises(Terminated), event_loop.terminable():
        signal.raise_signal(signal.SIGTERM)
    assert signal.getsignal(signal.SIGTERM) == before


def test_code_after_a_loop_is_still_terminable() -> None:
    with pytest.raises(Terminated), event_loop.terminable():
        event_loop.run(asyncio.sleep(0.0))
        signal.raise_signal(signal.SIGTERM)
