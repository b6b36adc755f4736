"""Eagerly started coroutines."""

import asyncio

import pytest

from endpoints.http.eager_coroutine import EagerCoroutine


async def test_one_that_need_not_wait_is_over_at_once() -> None:
    async def work() -> int:
        return 7

    begun = EagerCoroutine(work())
    assert begun.done
    assert await begun == 7


async def test_one_that_waits_goes_on_where_it_is_awaited() -> None:
    first, second = (asyncio.get_running_loop().create_future() for _ in range(2))

    async def work() -> list[int]:
        return [await first, await second]

    begun = EagerCoroutine(work())
    assert not begun.done
    first.set_result(1)
    asyncio.get_running_loop().call_later(0.01, second.set_result, 2)
    assert await begun == [1, 2]
    assert begun.done


async def test_what_is_raised_is_raised_where_it_is_awaited() -> None:
    async def work() -> None:
        await asyncio.sleep(0.01)
        raise KeyError("late")

    with pytest.raises(KeyError, match="late"):
        await EagerCoroutine(work())


async def test_time_that_runs_out_is_told_to_it() -> None:
    told: list[BaseException] = []

    async def work() -> None:
        try:
            await asyncio.sleep(60)
        except asyncio.CancelledError as error:
            told.append(error)
            raise

    with pytest.raises(TimeoutError):
        async with asyncio.timeout(0.01):
            await EagerCoroutine(work())
    assert len(told) == 1


async def test_one_that_will_not_be_cancelled_still_gives_its_result() -> None:
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
