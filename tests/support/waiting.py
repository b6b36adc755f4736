"""Waiting for conditions that nothing notifies of."""

import asyncio
import time
from collections.abc import Callable

PATIENCE = 90.0
"""Time limit [s]; long, since machines that run tests are busy."""

STEP = 0.005


async def until(condition: Callable[[], object], timeout: float = PATIENCE) -> float:
    """Wait until a condition holds, and return the seconds that it took."""
    loop = asyncio.get_running_loop()
    began = loop.time()
    async with asyncio.timeout(timeout):
        while not condition():
            await asyncio.sleep(STEP)
    return loop.time() - began


def wait_until(condition: Callable[[], object], timeout: float = PATIENCE) -> None:
    """Block until a condition holds, for tests of threads."""
    until = time.monotonic() + timeout
    while not condition():
        if time.monotonic() > until:
            raise TimeoutError
        time.sleep(STEP)
