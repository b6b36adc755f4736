"""Keeps the paths that were just found: whoever asked for one does not wait for the disk."""

import asyncio
import logging
from collections.abc import Callable, Sequence
from contextlib import suppress

from starlette.concurrency import run_in_threadpool

from engine.processes.background import Background
from ppaas.errors import InvalidInput, PPaaSError
from storage.ports import Store
from storage.records import PlanRecord

logger = logging.getLogger(__name__)

MOST_WAITING = 64
"""Plans that may wait for the store; whoever brings more waits with them."""

TOGETHER = 0.05
"""Seconds that plans wait for others: written together they take a third of the time, and few answers wait for it."""

Record = Callable[[], PlanRecord]


class PlanWriter:
    """Writes plans to the store beside the answers.

    A store writes through to the disk, which takes longer than to plan. What looks plans up waits until those under way
    are there, so an id that was given can be asked for at once. A plan that cannot be kept is told in the log.
    """

    def __init__(self) -> None:
        self._room = asyncio.Semaphore(MOST_WAITING)
        self._background = Background()
        self._waiting: list[tuple[Store, Record]] = []
        self._now = asyncio.Event()

    async def write(self, store: Store, record: Record) -> None:
        """Let the record of a plan be made and written soon; wait only while too many others are being written."""
        if self._room.locked():
            self._now.set()
        await self._room.acquire()
        self._waiting.append((store, record))
        if len(self._waiting) == 1:
            self._background.run(self._write_soon())

    async def _write_soon(self) -> None:
        with suppress(TimeoutError):
            await asyncio.wait_for(self._now.wait(), TOGETHER)
        self._now.clear()
        waiting, self._waiting = self._waiting, []
        try:
            for store in {id(store): store for store, _ in waiting}.values():
                records = [record for its_store, record in waiting if its_store is store]
                await run_in_threadpool(_write, store, records)
        finally:
            for _ in waiting:
                self._room.release()

    async def settled(self) -> None:
        """Wait until all plans that were brought so far are kept, or have failed."""
        if self._waiting:
            self._now.set()
        await self._background.join()


def _write(store: Store, makers: Sequence[Record]) -> None:
    records = [make() for make in makers]
    try:
        store.add_plans(records)
    except InvalidInput:  # one that cannot be kept is not to take the others along
        for record in records:
            _write_alone(store, record)
    except PPaaSError as error:
        logger.error("%d plans were not kept, from %s on: %s", len(records), records[0].id, error)


def _write_alone(store: Store, record: PlanRecord) -> None:
    try:
        store.add_plan(record)
    except PPaaSError as error:
        logger.error("the plan %s was not kept: %s", record.id, error)
