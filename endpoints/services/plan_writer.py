"""Writes new plans to the store in the background, so that path requests do not wait for the disk."""

import asyncio
import logging
from collections.abc import Callable, Sequence
from contextlib import suppress

from starlette.concurrency import run_in_threadpool

from engine.processes.background import Background
from engine.processes.occasional_log import OccasionalLog
from ppaas.errors import InvalidInput, PPaaSError
from storage.ports import Store
from storage.records import PlanRecord

logger = logging.getLogger(__name__)

MAX_WAITING = 64
"""Largest number of plans that wait for the store; beyond it `write` waits."""

BATCH_WINDOW = 0.05
"""Time that plans wait for others to be written with them [s]; a batch takes a third of the time of single writes."""

_UNSTORED = OccasionalLog(logger)

Record = Callable[[], PlanRecord]


class PlanWriter:
    """Writes plans to the store after their responses were sent.

    A store writes through to the disk, which takes longer than planning. Routes that look plans up call `settled`
    first, so that a returned id can be used at once. A plan that cannot be stored is logged.
    """

    def __init__(self) -> None:
        self._slots = asyncio.Semaphore(MAX_WAITING)
        self._background = Background()
        self._waiting: list[tuple[Store, Record]] = []
        self._write_now = asyncio.Event()

    async def write(self, store: Store, record: Record) -> None:
        """Queue a plan, whose record is built by ``record`` in a thread; wait only while too many plans are queued."""
        if self._slots.locked():
            self._write_now.set()
        await self._slots.acquire()
        self._waiting.append((store, record))
        if len(self._waiting) == 1:
            self._background.run(self._write_soon())

    async def _write_soon(self) -> None:
        with suppress(TimeoutError):
            await asyncio.wait_for(self._write_now.wait(), BATCH_WINDOW)
        self._write_now.clear()
        waiting, self._waiting = self._waiting, []
        try:
            for store in {id(store): store for store, _ in waiting}.values():
                records = [record for its_store, record in waiting if its_store is store]
                await run_in_threadpool(_write, store, records)
        finally:
            for _ in waiting:
                self._slots.release()

    async def settled(self) -> None:
        """Wait until all queued plans are stored or have failed."""
        if self._waiting:
            self._write_now.set()
        await self._background.join()


def _write(store: Store, makers: Sequence[Record]) -> None:
    records = [make() for make in makers]
    try:
        store.add_plans(records)
    except InvalidInput:  # one invalid plan must not prevent the others from being stored
        for record in records:
            _write_alone(store, record)
    except PPaaSError as error:
        _UNSTORED.warning("%d plans were not stored, the first is %s: %s", len(records), records[0].id, error)


def _write_alone(store: Store, record: PlanRecord) -> None:
    try:
        store.add_plan(record)
    except PPaaSError as error:
        logger.error("plan %s was not stored: %s", record.id, error)
