"""Concurrent coroutines that end together, each with time to clean up."""

import asyncio
from collections.abc import Coroutine
from typing import Any


async def run_together(*coroutines: Coroutine[Any, Any, None]) -> None:
    """Run coroutines concurrently. If one fails, or this is cancelled, cancel the others and wait for their end.

    Raises
    ------
    Exception
        The error of the coroutine that failed first.
    """
    tasks = [asyncio.create_task(each) for each in coroutines]
    try:
        done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_EXCEPTION)
    finally:
        for task in tasks:
            task.cancel()  # only once: a second cancel would interrupt its clean-up
        await asyncio.gather(*tasks, return_exceptions=True)
    for task in done:
        task.result()
