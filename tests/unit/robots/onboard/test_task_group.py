"""Coroutines that end together."""

import asyncio

import pytest

from ppaas.errors import Unavailable
from robots.onboard.task_group import run_together


class Work:
    """Runs until cancelled, and then may take time to clean up."""

    def __init__(self, leaving: float = 0.01) -> None:
        self.leaving = leaving
        self.begun = asyncio.Event()
        self.left = False

    async def run(self) -> None:
        try:
            self.begun.set()
            await asyncio.Event().wait()
        finally:
            await asyncio.sleep(self.leaving)
            self.left = True


async def test_cancelling_waits_until_all_coroutines_have_ended() -> None:
    works = Work(0.0), Work()
    task = asyncio.create_task(run_together(*(work.run() for work in works)))
    await works[1].begun.wait()
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert [work.left for work in works] == [True, True]


async def test_a_failing_coroutine_cancels_the_others_and_raises() -> None:
    work = Work()

    async def fail() -> None:
        await work.begun.wait()
        raise Unavailable("the one")

    with pytest.raises(Unavailable, match="the one"):
        await run_together(work.run(), fail())
    assert work.left


async def test_a_finished_coroutine_ends_no_other() -> None:
    work, ended = Work(), asyncio.Event()

    async def end() -> None:
        ended.set()

    task = asyncio.create_task(run_together(end(), work.run()))
    await ended.wait()
    await asyncio.sleep(0)
    assert not work.left and not task.done()
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)
