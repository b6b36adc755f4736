"""Waiting for conditions that nothing notifies of, with limits that fit the computer and what it does just now."""

import asyncio
import os
import time
from collections.abc import Callable
from functools import cache

PATIENCE = 90.0
"""Time limit [s] on a computer that does nothing else."""

STEP = 0.005

TURNS, REFERENCE = 200_000, 0.005
"""Turns of an empty loop, and the seconds that they take on the computer for which the limits were chosen."""

LONGEST = 8.0
"""Factor by which a limit grows at most: a test that hangs must end."""


async def until(condition: Callable[[], object], timeout: float = PATIENCE) -> float:
    """Wait until a condition holds, and return the seconds that it took."""
    loop = asyncio.get_running_loop()
    began = loop.time()
    while not condition():
        _check_time(loop.time() - began, timeout)
        await asyncio.sleep(STEP)
    return loop.time() - began


def wait_until(condition: Callable[[], object], timeout: float = PATIENCE) -> None:
    """Block until a condition holds, for tests of threads."""
    began = time.monotonic()
    while not condition():
        _check_time(time.monotonic() - began, timeout)
        time.sleep(STEP)


def _check_time(elapsed: float, timeout: float) -> None:
    if elapsed > timeout and elapsed > timeout * stretch():  # the load is read only where it matters
        raise TimeoutError(f"not within {elapsed:.1f} s")


def patience(seconds: float) -> asyncio.Timeout:
    """Limit a block that waits, by `asyncio.timeout`: for so many seconds on a computer that does nothing else."""
    return asyncio.timeout(seconds * stretch())


def stretch() -> float:
    """Return how many times as long as on an idle reference computer something may take here and now."""
    waiting, _, _ = os.getloadavg()
    return min(LONGEST, max(1.0, slowness() * max(1.0, waiting / len(os.sched_getaffinity(0)))))


@cache
def slowness() -> float:
    """Return how many times as long as on the reference computer one core takes here; the best of five."""
    return min(_seconds_of_a_loop() for _ in range(5)) / REFERENCE


def _seconds_of_a_loop() -> float:
    began = time.perf_counter()
    for _ in range(TURNS):
        pass
    return time.perf_counter() - began
