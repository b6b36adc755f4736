"""Background tasks: their failures are logged, and their owner can wait for them. Some repeat a check."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any

logger = logging.getLogger(__name__)


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
