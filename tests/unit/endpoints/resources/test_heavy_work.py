"""Heavy work runs in turns, of which one user has some only."""

import asyncio
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import pytest

from endpoints.resources import heavy_work
from endpoints.resources.heavy_work import HeavyWork, callable_in_thread
from ppaas.errors import Conflict, Unavailable


async def test_turns_are_limited_in_all_and_for_one_user() -> None:
    work, running, most = HeavyWork(at_once=3, of_user=2), list[str](), list[int]()
    go = asyncio.Event()

    async def run(user: str) -> None:
        async with work.turn(user):
            running.append(user)
            most.append(len(running))
            await go.wait()
            running.remove(user)

    tasks = [asyncio.create_task(run(user)) for user in ["ann"] * 20 + ["bob"] * 2]
    for _ in range(10):
        await asyncio.sleep(0)
    assert sorted(running) == ["ann", "ann", "bob"]
    go.set()
    await asyncio.gather(*tasks)
    assert max(most) == 3
    assert not work._users


async def test_a_turn_of_a_user_does_not_wait_for_others() -> None:
    work = HeavyWork(at_once=1, of_user=1)
    async with work.turn("ann"), work.turn_of_user("bob"):
        waiting = asyncio.create_task(work.turn_of_user("bob").__aenter__())
        await asyncio.sleep(0.01)
        assert not waiting.done()
    await waiting


async def test_a_cancelled_turn_is_given_to_the_next() -> None:
    work = HeavyWork(at_once=1, of_user=1)
    async with work.turn("ann"):
        waiting = asyncio.create_task(work.turn("ann").__aenter__())
        await asyncio.sleep(0)
        waiting.cancel()
        with pytest.raises(asyncio.CancelledError):
            await waiting
    async with asyncio.timeout(1.0), work.turn("ann"):
        pass
    assert not work._users


# Calls from threads to the event loop.


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
    monkeypatch.setattr(heavy_work, "PERIOD", 0.01)

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
