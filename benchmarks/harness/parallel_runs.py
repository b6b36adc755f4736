"""Runs of a bench in several processes."""

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import TypeVar

J = TypeVar("J")
R = TypeVar("R")


def run_all(
    run: Callable[[J], R], jobs: Sequence[J], processes: int, done: Callable[[], None], *, fresh: bool = False
) -> list[R]:
    """Run a function on each job; return the results in the order of the jobs.

    Parameters
    ----------
    run : callable
        Function of a module, so that it can be pickled.
    jobs : sequence
        Arguments, one for each call.
    processes : int
        Number of processes; with one, all jobs run in this process.
    done : callable
        Called after each run.
    fresh : bool
        Run each job in a new process, so that its peak memory is its own.
    """
    if processes == 1 and not fresh:
        return [_told(run(job), done) for job in jobs]
    others = multiprocessing.active_children()
    # A fork after kernels have started threads may hang, so processes are spawned.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, context, max_tasks_per_child=1 if fresh else None) as pool:
        futures = [pool.submit(run, job) for job in jobs]
        try:
            for future in as_completed(futures):
                _told(future.result(), done)
        except BaseException:  # Ctrl-C, SIGTERM or a failed job: the pool would still run all remaining jobs
            for process in set(multiprocessing.active_children()).difference(others):
                process.kill()
            raise
        return [future.result() for future in futures]


def _told(result: R, done: Callable[[], None]) -> R:
    done()
    return result
