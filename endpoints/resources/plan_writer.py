"""Writes new plans to the store in the background, so that path requests do not wait for the disk.

Plans that the store cannot take now, as on a full disk, wait in memory and are written when it can: what was answered
with an id is found by it. When too many wait, no further ones are accepted, and their paths are answered without an id.
"""

import asyncio
import logging
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial

from starlette.concurrency import run_in_threadpool

from engine.processes.background import Background
from engine.processes.occasional_log import OccasionalLog
from ppaas.errors import InvalidInput, PPaaSError, Unavailable
from ppaas.tracing.spans import Span, span
from storage.ports import Store
from storage.records import PlanRecord

logger = logging.getLogger(__name__)

MAX_WAITING = 64
"""Largest number of plans that wait for the store; beyond it `write` waits."""

BATCH_WINDOW = 0.05
"""Time that plans wait for others to be written with them [s]; a batch takes a third of the time of single writes."""

MOST_UNSTORED, MOST_UNSTORED_BYTES = 10_000, 32 << 20
"""Bounds of the plans that wait until the store takes them: their number, and the size of their poses [bytes]."""

RETRY = 1.0
"""Time between two attempts to write them [s]."""

AT_ONCE = 64
"""Number of them that are written at once."""

Record = Callable[[], PlanRecord]


class PlanWriter:
    """Writes plans to the store after their responses were sent.

    A store writes through to the disk, which takes longer than planning. Routes that look plans up call `settled`
    first, so that a returned id can be used at once, and look among the `unstored` ones. A plan that is invalid is
    logged.

    Parameters
    ----------
    retry : float
        Time between two attempts to write plans that the store did not take [s].
    """

    def __init__(self, retry: float = RETRY) -> None:
        self._retry = retry
        self._slots = asyncio.Semaphore(MAX_WAITING)
        self._background = Background()
        self._waiting: list[tuple[Store, Record, Span]] = []
        self._write_now = asyncio.Event()
        self._unstored: dict[str, tuple[Store, PlanRecord]] = {}
        self._unstored_bytes = 0
        self._retrying: asyncio.Task[None] | None = None
        self._writing = asyncio.Lock()
        self._log = OccasionalLog(logger)

    @property
    def accepts(self) -> bool:
        """Whether a further plan would be stored, now or later."""
        return len(self._unstored) < MOST_UNSTORED and self._unstored_bytes < MOST_UNSTORED_BYTES

    def unstored(self, plan_id: str) -> PlanRecord | None:
        """Return a plan that waits until the store takes it, or None."""
        found = self._unstored.get(plan_id)
        return None if found is None else found[1]

    async def forget(self, unwanted: Callable[[PlanRecord], bool]) -> int:
        """Drop those waiting plans for which a function returns true, since they were removed; return their number."""
        async with self._writing:  # a plan that is just being written is stored, or waits, afterwards
            names = [name for name, (_, record) in self._unstored.items() if unwanted(record)]
            for name in names:
                self._drop(name)
        return len(names)

    async def write(self, store: Store, record: Record) -> None:
        """Queue a plan, whose record is built by ``record`` in a thread; wait only while too many plans are queued."""
        if self._slots.locked():
            self._write_now.set()
        await self._slots.acquire()
        self._waiting.append((store, record, span("storage of a plan")))
        # The others are written with the first.
        if len(self._waiting) == 1:
            self._background.run(self._write_soon())

    async def settled(self) -> None:
        """Wait until all queued plans are stored, wait for the store, or have failed."""
        if self._waiting:
            self._write_now.set()
        await self._background.join()

    async def close(self) -> None:
        """Write all plans that the store takes now; the others are lost, which is logged."""
        await self.settled()
        if self._retrying is not None:
            self._retrying.cancel()
        await self._write_unstored()
        if self._unstored:
            logger.error("%d plans are lost that the store did not take: see the lines above", len(self._unstored))

    # -- internals -----------------------------------------------------------------------------------------------------

    async def _write_soon(self) -> None:
        with suppress(TimeoutError):
            await asyncio.wait_for(self._write_now.wait(), BATCH_WINDOW)
        self._write_now.clear()
        waiting, self._waiting = self._waiting, []
        try:
            for store in {id(store): store for store, _, _ in waiting}.values():
                records = [record for its_store, record, _ in waiting if its_store is store]
                for refused in await run_in_threadpool(self._store, store, records):
                    self._keep(store, refused)
        finally:
            for _, _, stored in waiting:
                stored.end()
                self._slots.release()

    def _keep(self, store: Store, record: PlanRecord) -> None:
        self._unstored[record.id] = store, record
        self._unstored_bytes += len(record.poses)
        if self._retrying is None or self._retrying.done():
            self._retrying = asyncio.create_task(self._retry_until_stored())

    async def _retry_until_stored(self) -> None:
        while self._unstored:
            await asyncio.sleep(self._retry)
            await self._write_unstored()
        self._log.is_over("all plans that waited for the store are stored")

    async def _write_unstored(self) -> None:
        """Write waiting plans, oldest first, until the store takes no more."""
        while self._unstored:
            async with self._writing:
                oldest = list(self._unstored.values())[:AT_ONCE]
                for store in {id(store): store for store, _ in oldest}.values():
                    mine = [record for its_store, record in oldest if its_store is store]
                    refused = await run_in_threadpool(self._store, store, [partial(_itself, record) for record in mine])
                    if refused:
                        return
                    for record in mine:
                        self._drop(record.id)

    def _drop(self, plan_id: str) -> None:
        found = self._unstored.pop(plan_id, None)
        if found is not None:
            self._unstored_bytes -= len(found[1].poses)

    def _store(self, store: Store, makers: Sequence[Record]) -> list[PlanRecord]:
        """Store plans; return those that the store cannot take now."""
        records = [make() for make in makers]
        try:
            store.add_plans(records)
        except InvalidInput:  # one invalid plan must not prevent the others from being stored
            return [record for record in records if not self._is_done(store, record)]
        except PPaaSError as error:
            self._log.warning("%d plans wait until the store takes them: %s", len(records), error)
            return records
        return []

    def _is_done(self, store: Store, record: PlanRecord) -> bool:
        """Store a plan; return whether it is stored, or will never be."""
        try:
            store.add_plan(record)
        except Unavailable as error:
            self._log.warning("plan %s waits until the store takes it: %s", record.id, error)
            return False
        except PPaaSError as error:
            logger.error("plan %s was not stored: %s", record.id, error)
        return True


def _itself(record: PlanRecord) -> PlanRecord:
    return record
