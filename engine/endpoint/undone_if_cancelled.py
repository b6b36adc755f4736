"""Work that goes on although its caller is cancelled, as a call of the master does, and is undone then."""

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

T = TypeVar("T")


async def undone_if_cancelled(work: Coroutine[Any, Any, T], undo: Callable[[T], object]) -> T:
    """Return the result of work; if the caller is cancelled meanwhile, call ``undo`` with the result."""

    def finished(working: asyncio.Task[T]) -> None:
        if not working.cancelled() and working.exception() is None:
            undo(working.result())

    working = asyncio.create_task(work)
    try:
        return await asyncio.shield(working)
    except asyncio.CancelledError:
        working.add_done_callback(finished)
        raise
