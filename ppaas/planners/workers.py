"""Threads: for many searches at a time, which end before the call does that began them, and to help with one."""

import os
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, as_completed, wait
from functools import cache, partial
from typing import TypeVar

from ppaas.errors import PlanCancelled
from ppaas.planners.helper_threads import HelperThreads
from ppaas.planners.watch import proceed

T = TypeVar("T")
R = TypeVar("R")

Check = Callable[[], None]
Worker = Callable[[T, Check], R]

PATIENCE = 0.000_2
"""How long who is out of work waits for one of the helpers to be done before it looks again [s]."""


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


class Helpers:
    """Those who help with one piece of work."""

    def __init__(self) -> None:
        self._at_work: list[Future[object]] = []

    def call(self, work: Callable[[], object]) -> None:
        """Let one more help: it calls ``work``, which is to return soon when there is nothing to do."""
        self._see_who_left()
        if not self._at_work:
            _threads().keep_off()
        self._at_work.append(_threads().submit(work))

    def rest(self) -> None:
        """Wait a moment, as long as none leaves."""
        wait(self._at_work, PATIENCE, FIRST_COMPLETED)
        self._see_who_left()

    def send_away(self) -> None:
        """Let nobody begin who has not; all others must have been told."""
        self._at_work = [future for future in self._at_work if not future.cancel()]

    def wait(self) -> None:
        """Wait until all have left."""
        for future in self._at_work:
            future.result()
        self._at_work.clear()

    def forget(self) -> None:
        """Do not wait for those who are about to leave, nor tell what went wrong with them."""
        self._at_work.clear()

    def _see_who_left(self) -> None:
        left = [future for future in self._at_work if future.done()]
        for future in left:
            future.result()
            self._at_work.remove(future)


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
    left, called = iter(slices), Helpers()

    def take(check: Check) -> None:
        for one in left:
            check()
            work(one)

    for _ in range(helpers):
        called.call(partial(take, proceed))
    try:
        take(check)
    finally:
        deque(left, 0)  # whoever still works finds nothing more
        called.send_away()
        called.wait()


@cache
def _threads() -> HelperThreads:
    return HelperThreads()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_threads.cache_clear)  # of the parent's threads a child has none
