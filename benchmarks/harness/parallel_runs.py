"""Runs of a benchmark in processes of their own."""

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import TypeVar

J = TypeVar("J")
R = TypeVar("R")


def run_all(run: Callable[[J], R], jobs: Sequence[J], processes: int, done: Callable[[], None]) -> list[R]:
    """Return what comes of each job, in their order, whichever process ran it.

    Parameters
    ----------
    run : callable
        A function of a module.
    jobs : sequence
        What it is called with.
    processes : int
        With one, all is run in this process.
    done : callable
        Called after each run.
    """
    if processes == 1:
        return [_told(run(job), done) for job in jobs]
    others = multiprocessing.active_children()
    # A fork after kernels have had threads may hang: each process begins anew.
    with ProcessPoolExecutor(processes, multiprocessing.get_context("spawn")) as pool:
        futures = [pool.submit(run, job) for job in jobs]
        try:
            for future in as_completed(futures):
                _told(future.result(), done)
        except BaseException:  # Ctrl-C or SIGTERM, or a job that failed: the pool would run all that are left
            for process in set(multiprocessing.active_children()).difference(others):
                process.kill()
            raise
        return [future.result() for future in futures]


def _told(result: R, done: Callable[[], None]) -> R:
    done()
    return result
