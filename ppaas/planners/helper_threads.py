"""Threads that help wake on other CPUs than the one that calls them.

Linux may wake a thread on the CPU of who wakes it even if another is idle, and let it run at once: then the caller
waits until its helper is done. So they are kept off it.
"""

import ctypes
import os
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import cache


class HelperThreads:
    """Threads that are kept off the CPU of who is about to wake them."""

    def __init__(self) -> None:
        self._kept: dict[int, set[int]] = {}

    def enlist(self) -> None:
        """Make the thread that calls this one of them."""
        self._kept[threading.get_native_id()] = set()

    def keep_off(self) -> None:
        """Keep them to the CPUs that the caller may use, and off the one that it runs on, if there is another."""
        here = _sched_getcpu()
        if here is None:
            return
        allowed = os.sched_getaffinity(0)
        others = allowed - {here()} or allowed
        for thread, kept in list(self._kept.items()):
            if kept != others:
                self._kept[thread] = others
                with suppress(OSError):  # forbidden here, or these CPUs have just been taken away
                    os.sched_setaffinity(thread, others)


@cache
def _sched_getcpu() -> Callable[[], int] | None:
    """Return what tells the number of the CPU that a thread runs on, where threads can be kept to some."""
    if not hasattr(os, "sched_setaffinity"):
        return None
    return getattr(ctypes.CDLL(None), "sched_getcpu", None)
