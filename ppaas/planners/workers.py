"""Threads: for many searches at a time, which end before the call does that began them, and to help with one."""

import os
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed, wait
from functools import cache, partial
from typing import TypeVar

from ppaas.errors import PlanCancelled
from ppaas.planners.helper_threads import HelperThreads
from ppaas.planners.watch import proceed

T = TypeVar("T")
R = TypeVar("R")

Check = Callable[[], None]
Worker = Callable[[T, Check], R]


def work_off(workers: Sequence[Worker[T, R]], jobs: Sequence[T], *, check: Check, done: Callable[[T], None]) -> list[R]:
    """Have jobs done, each by one of the workers, and return what came of them in the order of the jobs.

    The first error ends all: no job is begun after it, and the check of those at work raises.

    Parameters
    ----------
    workers : sequence of callable
        Each takes a job and a check that it must call often; none is called twice at a time. There are as many threads
        as workers; one alone works in the caller's thread.
    jobs : sequence
    check : callable
        What the workers' checks ask; several threads may call it at a time. What it raises ends the work.
    done : callable
        Called in the caller's thread with each job that is done, in any order.
    """
    if len(workers) == 1:
        return _alone(workers[0], jobs, check, done)
    stopped = False
    idle = deque(workers)
    results: dict[int, R] = {}

    def asked() -> None:
        if stopped:
            raise PlanCancelled("another of these searches failed")
        check()

    def do(number: int) -> int:
        worker = idle.popleft()
        try:
            results[number] = worker(jobs[number], asked)
        finally:
            idle.append(worker)
        return number

    with ThreadPoolExecutor(len(workers)) as threads:
        futures = [threads.submit(do, number) for number in range(len(jobs))]
        try:
            for future in as_completed(futures):
                done(jobs[future.result()])
        finally:
            stopped = True
            for future in futures:
                future.cancel()
    return [results[number] for number in range(len(jobs))]


def _alone(worker: Worker[T, R], jobs: Sequence[T], check: Check, done: Callable[[T], None]) -> list[R]:
    results = []
    for job in jobs:
        results.append(worker(job, check))
        done(job)
    return results


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
