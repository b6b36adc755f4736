"""All runs of the mapping bench, each in a fresh process, so that its peak memory is its own."""

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any

from benchmarks.mapping.run import SlamJob, run


def measure(jobs: Sequence[SlamJob], processes: int, done: Callable[[], None]) -> list[dict[str, Any]]:
    """Map all logs; return the results in the order of the jobs. ``done`` is called after each run."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, context, max_tasks_per_child=1) as pool:
        futures = [pool.submit(run, job) for job in jobs]
        for future in futures:
            future.add_done_callback(lambda _: done())
        return [future.result() for future in futures]
