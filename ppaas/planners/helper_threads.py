"""Helper threads of one search, which wake on other CPUs than the caller's.

Linux may wake a thread on the CPU of its waker even if another CPU is idle, and run it at once: the caller then waits
until its helper is done. The affinity of the helpers is therefore set to exclude the caller's CPU.
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
    """Registered threads, whose affinity excludes the CPU of the thread that is about to wake them."""

    def __init__(self) -> None:
        self._affinity: dict[int, set[int]] = {}

    def register(self) -> None:
        """Register the calling thread."""
        self._affinity[threading.get_native_id()] = set()

    def move_off_this_cpu(self) -> None:
        """Allow the registered threads the caller's CPUs, without the one that it runs on if it has several."""
        here = _sched_getcpu()
        if here is None:
            return
        allowed = os.sched_getaffinity(0)
        others = allowed - {here()} or allowed
        for thread, affinity in list(self._affinity.items()):
            if affinity != others:
                self._affinity[thread] = others
                with suppress(OSError):  # not permitted here, or these CPUs have just been removed
                    os.sched_setaffinity(thread, others)


@cache
def _sched_getcpu() -> Callable[[], int] | None:
    """Return the C library's ``sched_getcpu``, or None where the affinity of threads cannot be set."""
    if not hasattr(os, "sched_setaffinity"):
        return None
    return getattr(ctypes.CDLL(None), "sched_getcpu", None)


def share(slices: Sequence[T], work: Callable[[T], object], *, helpers: int, check: Check) -> None:
    """Process slices in this thread and in helper threads; each slice goes to the first thread that is free.

    Parameters
    ----------
    slices : sequence
    work : callable
        Called with each slice.
    helpers : int
        Maximum number of helper threads.
    check : callable
        Called by this thread before each slice. An exception from it ends the work, and is raised when all helpers
        have finished.
    """
    left = iter(slices)

    def take(check: Check) -> None:
        for item in left:
            check()
            work(item)

    called = _start_helpers(partial(take, proceed), helpers)
    try:
        take(check)
    finally:
        deque(left, 0)  # exhaust the iterator, so that helpers take no further slice
        at_work = [future for future in called if not future.cancel()]
        wait(at_work)
    for future in at_work:
        future.result()


def _start_helpers(work: Callable[[], object], count: int) -> list[Future[object]]:
    """Call ``work`` in ``count`` helper threads."""
    if count < 1:
        return []
    executor, threads = _helpers()
    threads.move_off_this_cpu()
    return [executor.submit(work) for _ in range(count)]


@cache
def _helpers() -> tuple[ThreadPoolExecutor, HelperThreads]:
    """Return the pool of helper threads, which are started on demand, at most one per CPU."""
    threads = HelperThreads()
    return ThreadPoolExecutor(os.cpu_count(), "planning", initializer=threads.register), threads


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_helpers.cache_clear)  # threads do not survive a fork
