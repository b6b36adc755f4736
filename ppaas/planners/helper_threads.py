"""Threads that help with slices of one search, and wake on other CPUs than the one that calls them.

Linux may wake a thread on the CPU of who wakes it even if another is idle, and let it run at once: then the caller
waits until its helper is done. So they are kept off it.
"""

import ctypes
import os
import threading
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import suppress
from functools import cache, partial
from typing import TypeVar

from ppaas.planners.watch import proceed

T = TypeVar("T")

Check = Callable[[], None]


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


def share(slices: Sequence[T], work: Callable[[T], object], *, helpers: int, check: Check) -> None:
    """Work off slices in this thread and in those of helpers: each is done by who comes to it first.

    Parameters
    ----------
    slices : sequence
    work : callable
        What is done with each.
    helpers : int
        How many may help.
    check : callable
        This thread calls it before each slice. What it raises ends the work; it is raised when all have left.
    """
    left = iter(slices)

    def take(check: Check) -> None:
        for one in left:
            check()
            work(one)

    called = _call(partial(take, proceed), helpers)
    try:
        take(check)
    finally:
        deque(left, 0)  # whoever still works finds nothing more
        at_work = [future for future in called if not future.cancel()]
        wait(at_work)
    for future in at_work:
        future.result()


def _call(work: Callable[[], object], count: int) -> list[Future[object]]:
    """Let so many help with some work."""
    if count < 1:
        return []
    executor, threads = _helpers()
    threads.keep_off()
    return [executor.submit(work) for _ in range(count)]


@cache
def _helpers() -> tuple[ThreadPoolExecutor, HelperThreads]:
    """Return threads that are started as they are needed, one for each CPU at most."""
    threads = HelperThreads()
    return ThreadPoolExecutor(os.cpu_count(), "planning", initializer=threads.enlist), threads


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_helpers.cache_clear)  # of the parent's threads a child has none
