"""Keeps the paths that were just found: whoever asked for one does not wait for the disk."""

import asyncio
from collections.abc import Callable

from starlette.concurrency import run_in_threadpool

from engine.background import Background
from storage.ports import Store
from storage.records import PlanRecord

MOST_WAITING = 64
"""Plans that may wait for the store; whoever brings more waits with them."""

ANSWER_FIRST = 0.002
"""Seconds in which an answer is on its way before its plan is written: the two would wait for each other's thread."""


class PlanKeeper:
    """Writes plans to the store beside the answers.

    A store writes through to the disk, which takes longer than to plan. What looks plans up waits until those under way
    are there, so an id that was given can be asked for at once. A plan that cannot be kept is told in the log.
    """

    def __init__(self) -> None:
        self._room = asyncio.Semaphore(MOST_WAITING)
        self._background = Background()

    async def keep(self, store: Store, record: Callable[[], PlanRecord]) -> None:
        """Begin to make the record of a plan and to write it; wait only while too many others are being written."""
        await self._room.acquire()
        self._background.run(self._write(store, record))

    async def _write(self, store: Store, record: Callable[[], PlanRecord]) -> None:
        try:
            await asyncio.sleep(ANSWER_FIRST)
            await run_in_threadpool(lambda: store.add_plan(record()))
        finally:
            self._room.release()

    async def settled(self) -> None:
        """Wait until all plans that were brought so far are kept, or have failed."""
        await self._background.join()
