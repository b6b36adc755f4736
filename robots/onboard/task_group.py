"""Works that belong together, each of which may have something to leave in order."""

import asyncio
from collections.abc import Coroutine
from typing import Any


async def together(*works: Coroutine[Any, Any, None]) -> None:
    """Run all works to their ends; where one fails, or this is cancelled, end the others, and wait until they have.

    Raises
    ------
    Exception
        What the first that failed did.
    """
    tasks = [asyncio.create_task(work) for work in works]
    try:
        done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_EXCEPTION)
    finally:
        for task in tasks:
            task.cancel()  # once: a second time would break off what it does to leave
        await asyncio.gather(*tasks, return_exceptions=True)
    for task in done:
        task.result()
