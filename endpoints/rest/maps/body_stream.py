"""A body on its way into a thread that may block: what has come is taken while more comes."""

import asyncio
from collections.abc import AsyncIterator, Callable, Iterable

from starlette.concurrency import run_in_threadpool

AT_ONCE = 1 << 20
"""Bytes that must have come before a thread is asked to take them: to ask costs as much as some ten thousand."""

MOST = 4 << 20
"""Bytes that wait at most while a thread takes others."""

Take = Callable[[bytes], object]


async def taken(stream: AsyncIterator[bytes], take: Take) -> None:
    """Have threads take a body, block by block in its order, one at a time.

    However it ends, no thread takes anything any more.

    Parameters
    ----------
    stream : async iterator of bytes
        The body. Nothing is read of it while so much waits that more would fill the memory.
    take : callable
        Takes a block; what it raises is raised here.
    """
    taking = _Taking(take)
    try:
        waiting: list[bytes] = []
        size = 0
        async for block in stream:
            waiting.append(block)
            size += len(block)
            if size >= MOST or (size >= AT_ONCE and taking.is_idle):
                await taking.next(waiting)
                waiting, size = [], 0
        await taking.next(waiting)
        await taking.end()
    finally:
        await taking.settle()


class _Taking:
    """The thread that takes blocks, if there is one."""

    def __init__(self, take: Take) -> None:
        self._take = take
        self._task: asyncio.Task[None] | None = None

    @property
    def is_idle(self) -> bool:
        return self._task is None or self._task.done()

    async def next(self, blocks: list[bytes]) -> None:
        """Have blocks taken once those before are; raise what came of those."""
        await self.end()
        self._task = asyncio.create_task(run_in_threadpool(_take_all, self._take, blocks))

    async def end(self) -> None:
        """Wait for the thread; raise what it raised."""
        if error := await self.settle():
            raise error

    async def settle(self) -> BaseException | None:
        """Wait for the thread, which who is cancelled meanwhile does not stop; return what it raised."""
        if self._task is None:
            return None
        await asyncio.wait([self._task])
        return self._task.exception()


def _take_all(take: Take, blocks: Iterable[bytes]) -> None:
    for block in blocks:
        take(block)
