"""Turns of users."""

import asyncio
import threading
import time

import pytest

from endpoints.accounts import user_turns
from endpoints.accounts.user_turns import LocalTurns, Turn, in_turn
from ppaas.errors import Conflict, Unavailable


async def test_turns_of_a_user_are_in_order_and_those_of_others_do_not_wait() -> None:
    turns, events = LocalTurns(), list[str]()

    async def take(user: str, name: str) -> None:
        async with turns.turn(user):
            events.append(f"{name} begins")
            await asyncio.sleep(0.01)
            events.append(f"{name} ends")

    await asyncio.gather(take("ann", "1"), take("ann", "2"), take("bob", "3"))
    assert events[:2] == ["1 begins", "3 begins"]
    assert [event for event in events if "3" not in event] == ["1 begins", "1 ends", "2 begins", "2 ends"]


async def test_a_turn_names_the_one_before_if_it_is_remembered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(user_turns, "MAX_REMEMBERED", 2)
    turns = LocalTurns()
    taken = list[Turn]()
    for user in ("ann", "bob", "ann", "cid", "dan", "ann"):
        async with turns.turn(user) as turn:
            taken.append(turn)
    assert [turn.before for turn in taken] == [None, None, taken[0].id, None, None, None]
    assert len({turn.id for turn in taken}) == len(taken)


async def test_only_so_many_wait_for_a_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(user_turns, "MAX_WAITING", 2)
    turns = LocalTurns()

    async def take(user: str) -> None:
        async with turns.turn(user):
            await asyncio.sleep(0.0)

    results = await asyncio.gather(
        *(take(user) for user in ("ann", "bob", "ann", "ann", "ann")), return_exceptions=True
    )
    assert [type(result) for result in results] == [type(None)] * 4 + [Unavailable]
    await take("ann")


async def test_work_in_a_turn_returns_its_result_or_raises_its_error() -> None:
    turns = LocalTurns()

    def fail(_turn: Turn) -> None:
        raise Conflict("not so")

    assert await in_turn(turns, "ann", lambda turn: turn.before) is None
    with pytest.raises(Conflict):
        await in_turn(turns, "ann", fail)
    assert await in_turn(turns, "ann", lambda turn: turn.before) is not None


async def test_a_turn_does_not_end_before_its_work_if_the_caller_is_cancelled() -> None:
    turns, begun, end, events = LocalTurns(), threading.Event(), threading.Event(), list[str]()

    def work(_turn: Turn) -> None:
        begun.set()
        assert end.wait(10.0)
        events.append("work")
        raise Conflict("nobody asks for it")

    cancelled = asyncio.create_task(in_turn(turns, "ann", work))
    await asyncio.to_thread(begun.wait, 10.0)
    next_one = asyncio.create_task(in_turn(turns, "ann", lambda _: events.append("next")))
    for _ in range(2):
        cancelled.cancel()
        await asyncio.sleep(0.01)
    assert not cancelled.done()
    end.set()
    await next_one
    assert events == ["work", "next"]
    with pytest.raises(asyncio.CancelledError):
        await cancelled


async def test_who_gives_up_waiting_leaves_the_others_their_turn() -> None:
    turns = LocalTurns()
    first = asyncio.create_task(in_turn(turns, "ann", lambda _: time.sleep(0.05)))
    await asyncio.sleep(0.01)
    second, third = [asyncio.create_task(in_turn(turns, "ann", lambda _: 3)) for _ in range(2)]
    await asyncio.sleep(0.01)
    second.cancel()
    assert await third == 3
    await first
