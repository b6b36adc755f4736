"""Passes a request body to a blocking consumer in a thread while more of the body arrives."""

import asyncio
from collections.abc import AsyncIterator, Callable, Iterable

from starlette.concurrency import run_in_threadpool

MIN_BATCH = 1 << 20
"""Bytes collected before they are handed to a thread; a handover costs as much as consuming about 10 kB."""

MAX_WAITING = 4 << 20
"""Largest number of bytes that wait while a thread consumes others."""

Take = Callable[[bytes], object]


async def consume(stream: AsyncIterator[bytes], take: Take) -> None:
    """Pass a body to a blocking function, block by block and in order, in one thread at a time.

    No thread runs any more when this function returns or raises.

    Parameters
    ----------
    stream : async iterator of bytes
        The body. It is not read while `MAX_WAITING` bytes wait for the thread.
    take : callable
        Called with each block; its exception is raised here.
    """
    consumer = _BlockConsumer(take)
    try:
        waiting: list[bytes] = []
        size = 0
        async for block in stream:
            waiting.append(block)
            size += len(block)
            if size >= MAX_WAITING or (size >= MIN_BATCH and consumer.is_idle):
                await consumer.next(waiting)
                waiting, size = [], 0
        await consumer.next(waiting)
        await consumer.end()
    finally:
        await consumer.settle()


class _BlockConsumer:
    """Runs the consuming function in a thread, one batch of blocks after the other."""

    def __init__(self, take: Take) -> None:
        self._take = take
        self._task: asyncio.Task[None] | None = None

    @property
    def is_idle(self) -> bool:
        return self._task is None or self._task.done()

    async def next(self, blocks: list[bytes]) -> None:
        """Start consuming blocks after the previous batch; raise the exception of the previous batch."""
        await self.end()
        self._task = asyncio.create_task(run_in_threadpool(_take_all, self._take, blocks))

    async def end(self) -> None:
        """Wait for the thread; raise its exception."""
        if error := await self.settle():
            raise error

    async def settle(self) -> BaseException | None:
        """Wait for the thread, which cancellation of the caller does not stop; return its exception."""
        if self._task is None:
            return None
        await asyncio.wait([self._task])
        return self._task.exception()


def _take_all(take: Take, blocks: Iterable[bytes]) -> None:
    for block in blocks:
        take(block)
