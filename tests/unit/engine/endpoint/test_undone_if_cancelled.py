"""Work goes on although its caller is cancelled, and is undone then."""

import asyncio

import pytest

from engine.endpoint.master_link import undone_if_cancelled
from ppaas.errors import Unavailable
from tests.support.waiting import until


async def test_the_result_of_a_caller_that_waits_is_kept() -> None:
    undone: list[int] = []
    assert await undone_if_cancelled(asyncio.sleep(0.0, 7), undone.append) == 7
    assert undone == []


async def test_the_result_is_undone_if_the_caller_is_cancelled() -> None:
    undone, may_end = list[int](), asyncio.Event()

    async def work() -> int:
        await may_end.wait()
        return 7

    waiting = asyncio.create_task(undone_if_cancelled(work(), undone.append))
    await asyncio.sleep(0.0)
    waiting.cancel()
    with pytest.raises(asyncio.CancelledError):
        await waiting
    assert undone == []
    may_end.set()
    await until(lambda: undone == [7])


async def test_work_that_fails_has_nothing_to_undo() -> None:
    async def work() -> int:
        raise Unavailable("no master")

    with pytest.raises(Unavailable, match="no master"):
        await undone_if_cancelled(work(), lambda _: pytest.fail("there is no result"))
