"""The threads of all helpers, which begin their work on other CPUs than the one that calls them.

Linux may wake a thread on the CPU of who wakes it even if another is idle, and let it run at once: then the caller
waits until its helper is done. So those that sleep are told to wake elsewhere; once they work they may go anywhere.
"""

import ctypes
import os
import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from functools import cache


class HelperThreads:
    """Threads that are started as they are needed, one for each CPU at most."""

    def __init__(self) -> None:
        self._ids: list[int] = []
        self._executor = ThreadPoolExecutor(
            os.cpu_count(), "planning", initializer=lambda: self._ids.append(threading.get_native_id())
        )

    def submit(self, work: Callable[[], object]) -> Future[object]:
        """Let the first that is free do some work."""
        return self._executor.submit(_anywhere, threading.get_native_id(), work)

    def keep_off(self) -> None:
        """Let none of those that sleep wake on the CPU of the caller."""
        here = _sched_getcpu()
        if here is None:
            return
        others = os.sched_getaffinity(0) - {here()}
        for thread in self._ids if others else ():
            _allow(thread, others)


def _anywhere(caller: int, work: Callable[[], object]) -> object:
    """Do some work on any CPU that the caller may use: as of now, because it may be moved to others at any time."""
    if _sched_getcpu() is not None:
        with suppress(ProcessLookupError):  # it called off the work, and ended
            _allow(0, os.sched_getaffinity(caller))
    return work()


def _allow(thread: int, cpus: set[int]) -> None:
    """Let a thread use some CPUs, or leave it as it is where that is forbidden, or they have just been taken away."""
    with suppress(OSError):
        os.sched_setaffinity(thread, cpus)


@cache
def _sched_getcpu() -> Callable[[], int] | None:
    """Return what tells the number of the CPU that a thread runs on, where threads can be kept to some."""
    if not hasattr(os, "sched_setaffinity"):
        return None
    return getattr(ctypes.CDLL(None), "sched_getcpu", None)
