"""Jobs in parallel processes."""

import multiprocessing
import os
import time

import pytest

from benchmarks.harness.parallel_runs import run_all


def job(number: float) -> float:
    """Wait, or fail if the number is negative."""
    if number < 0.0:
        raise ValueError(number)
    time.sleep(number)
    return number


def test_results_have_the_order_of_the_jobs() -> None:
    done: list[None] = []
    for processes in (1, 2):
        assert run_all(job, [0.2, 0.0, 0.1], processes, lambda: done.append(None)) == [0.2, 0.0, 0.1]
    assert len(done) == 6


def pid(_job: int) -> int:
    """Return the process in which the job runs."""
    return os.getpid()


def test_each_job_has_a_process_of_its_own_if_asked() -> None:
    found = run_all(pid, [1, 2], 1, lambda: None, fresh=True)
    assert len({os.getpid(), *found}) == 3


def test_a_failing_job_ends_all_others() -> None:
    before = multiprocessing.active_children()
    began = time.monotonic()
    with pytest.raises(ValueError, match="-1"):
        run_all(job, [60.0, -1.0, 60.0], 2, lambda: None)
    assert time.monotonic() - began < 30.0
    assert set(multiprocessing.active_children()) <= set(before)
