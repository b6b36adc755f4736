"""Heavy work runs in turns, of which one user has some only."""

import asyncio

import pytest

from endpoints.services.heavy_work import HeavyWork


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
