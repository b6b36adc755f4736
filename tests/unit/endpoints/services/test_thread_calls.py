"""Calls from threads to the event loop."""

import asyncio
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import pytest

from endpoints.services import thread_calls
from endpoints.services.thread_calls import callable_in_thread
from ppaas.errors import Conflict, Unavailable


async def test_a_thread_gets_the_result_or_the_error_of_a_coroutine() -> None:
    async def half(number: int) -> int:
        await asyncio.sleep(0.0)
        if number % 2:
            raise Conflict("odd")
        return number // 2

    call = callable_in_thread(half)
    assert await asyncio.to_thread(call, 6) == 3
    with pytest.raises(Conflict, match="odd"):
        await asyncio.to_thread(call, 5)


def test_a_thread_does_not_wait_for_an_event_loop_that_has_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(thread_calls, "PERIOD", 0.01)

    async def callable_on_this_loop() -> Callable[[], bool]:
        return callable_in_thread(asyncio.Event().wait)

    loop = asyncio.new_event_loop()
    call = loop.run_until_complete(callable_on_this_loop())
    with ThreadPoolExecutor(1) as threads:
        waiting = threads.submit(call)
        time.sleep(0.05)
        loop.close()
        for result in (waiting, threads.submit(call)):
            with pytest.raises(Unavailable, match="stopping"):
                result.result(10.0)
