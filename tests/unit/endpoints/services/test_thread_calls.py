"""Calls from threads to the event loop."""

import asyncio

import pytest

from endpoints.services import thread_calls
from endpoints.services.thread_calls import callable_in_thread
from ppaas.errors import Conflict


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


async def test_a_thread_does_not_wait_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(thread_calls, "TIMEOUT", 0.01)
    with pytest.raises(TimeoutError):
        await asyncio.to_thread(callable_in_thread(asyncio.Event().wait))
