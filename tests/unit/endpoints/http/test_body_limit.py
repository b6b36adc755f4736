"""Eagerly started coroutines, by which bodies are read."""

import asyncio

import pytest

from endpoints.http.body_limit import EagerCoroutine


async def test_a_coroutine_that_never_waits_is_done_at_once() -> None:
    async def work() -> int:
        return 7

    begun = EagerCoroutine(work())
    assert begun.done
    assert await begun == 7


async def test_a_coroutine_that_waits_continues_where_it_is_awaited() -> None:
    first, second = (asyncio.get_running_loop().create_future() for _ in range(2))

    async def work() -> list[int]:
        return [await first, await second]

    begun = EagerCoroutine(work())
    assert not begun.done
    first.set_result(1)
    asyncio.get_running_loop().call_later(0.01, second.set_result, 2)
    assert await begun == [1, 2]
    assert begun.done


async def test_an_exception_is_raised_where_the_coroutine_is_awaited() -> None:
    async def work() -> None:
        await asyncio.sleep(0.01)
        raise KeyError("late")

    with pytest.raises(KeyError, match="late"):
        await EagerCoroutine(work())


async def test_a_timeout_cancels_the_coroutine() -> None:
    cancellations: list[BaseException] = []

    async def work() -> None:
        try:
            await asyncio.sleep(60)
        except asyncio.CancelledError as error:
            cancellations.append(error)
            raise

    with pytest.raises(TimeoutError):
        async with asyncio.timeout(0.01):
            await EagerCoroutine(work())
    assert len(cancellations) == 1


async def test_a_coroutine_that_suppresses_cancellation_returns_its_result() -> None:
    async def work() -> str:
        try:
            await asyncio.sleep(60)
        except asyncio.CancelledError:
            return "saved"
        return "slept"

    begun = EagerCoroutine(work())
    task = asyncio.current_task()
    assert task is not None
    asyncio.get_running_loop().call_later(0.01, task.cancel)
    assert await begun == "saved"
    task.uncancel()
