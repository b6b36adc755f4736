"""Threads that do many jobs at a time, and end before the call does that began them."""

from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import TypeVar

from ppaas.errors import PlanCancelled

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
