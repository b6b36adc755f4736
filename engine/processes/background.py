"""Background tasks of a process, and its stop.

Failures of background tasks are logged, and their owner can wait for them. Some repeat a check. SIGINT and SIGTERM stop
a process, whatever it is doing.
"""

import asyncio
import logging
import signal
from collections.abc import Awaitable, Callable, Coroutine, Iterable
from typing import Any, TypeVar

logger = logging.getLogger(__name__)

T = TypeVar("T")


# -- tasks -------------------------------------------------------------------------------------------------------------


async def repeat(check: Callable[[], Awaitable[object]], period: float) -> None:
    """Run a check, and again after each period [s], until cancelled.

    A check that fails is repeated, too. The first of several failures in a row is logged as an error.
    """
    failed = False
    while True:
        try:
            await check()
            failed = False
        except Exception:
            level = logging.DEBUG if failed else logging.ERROR
            logger.log(level, "a check failed; it is repeated every %g s", period, exc_info=True)
            failed = True
        await asyncio.sleep(period)


class Background:
    """The background tasks of one owner."""

    def __init__(self) -> None:
        self._tasks: set[asyncio.Task[None]] = set()

    def run(self, work: Coroutine[Any, Any, None]) -> None:
        """Start a coroutine as a task, without waiting for it."""
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._finished)

    def _finished(self, task: asyncio.Task[None]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and task.exception() is not None:
            logger.error("a background task failed", exc_info=task.exception())

    async def join(self) -> None:
        """Wait for all running tasks."""
        await asyncio.gather(*self._tasks, return_exceptions=True)

    async def cancel(self) -> None:
        """Cancel all running tasks and wait for their end."""
        for task in tuple(self._tasks):
            task.cancel()
        await self.join()


async def cancel_all(tasks: Iterable[asyncio.Task[Any]]) -> None:
    """Cancel tasks, and wait for their end; their errors are dropped."""
    tasks = tuple(tasks)
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


# -- stop by a signal --------------------------------------------------------------------------------------------------


def stop_on_signals() -> asyncio.Event:
    """Return an event that SIGINT and SIGTERM set; the log says which of them came."""
    stop = asyncio.Event()

    def end(number: signal.Signals) -> None:
        logger.info("this process ends: it got %s", number.name)
        stop.set()

    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, end, number)
    return stop


async def first_of(events: Iterable[asyncio.Event]) -> None:
    """Wait until one of several events is set."""
    waiting = [asyncio.create_task(event.wait()) for event in events]
    try:
        await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED)
    finally:
        await cancel_all(waiting)


async def run_unless_stopped(stop: asyncio.Event, work: Coroutine[Any, Any, T]) -> T | None:
    """Return the result of ``work``; cancel it and return None if ``stop`` is set first."""
    working, stopping = asyncio.create_task(work), asyncio.create_task(stop.wait())
    try:
        await asyncio.wait((working, stopping), return_when=asyncio.FIRST_COMPLETED)
        return working.result() if working.done() else None
    finally:
        await cancel_all((working, stopping))
