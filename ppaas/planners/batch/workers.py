"""Pool of worker threads for one batch of jobs; all threads end before the call returns."""

from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import TypeVar

from ppaas.errors import PlanCancelled

T = TypeVar("T")
R = TypeVar("R")

Check = Callable[[], None]
Worker = Callable[[T, Check], R]


def run_jobs(workers: Sequence[Worker[T, R]], jobs: Sequence[T], *, check: Check, done: Callable[[T], None]) -> list[R]:
    """Run jobs on workers and return the results in the order of the jobs.

    The first error ends the batch: no further job is started, and the checks of the running jobs raise.

    Parameters
    ----------
    workers : sequence of callable
        Each takes a job and a check that it must call often. A worker runs one job at a time, in its own thread; a
        single worker runs in the caller's thread.
    jobs : sequence
    check : callable
        Called by the workers' checks, by several threads at once. An exception from it ends the work.
    done : callable
        Called in the caller's thread with each finished job, in any order.

    Raises
    ------
    Exception
        The first error of a job or of ``check``.
    """
    if len(workers) == 1:
        return _run_in_caller(workers[0], jobs, check, done)
    stopped = False
    idle = deque(workers)
    results: dict[int, R] = {}

    def check_both() -> None:
        if stopped:
            raise PlanCancelled("another search of the same batch failed")
        check()

    def run(number: int) -> int:
        worker = idle.popleft()
        try:
            results[number] = worker(jobs[number], check_both)
        finally:
            idle.append(worker)
        return number

    with ThreadPoolExecutor(len(workers)) as threads:
        futures = [threads.submit(run, number) for number in range(len(jobs))]
        try:
            for future in as_completed(futures):
                done(jobs[future.result()])
        finally:
            stopped = True
            for future in futures:
                future.cancel()
    return [results[number] for number in range(len(jobs))]


def _run_in_caller(worker: Worker[T, R], jobs: Sequence[T], check: Check, done: Callable[[T], None]) -> list[R]:
    results = []
    for job in jobs:
        results.append(worker(job, check))
        done(job)
    return results
