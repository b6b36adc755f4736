"""Short jobs: those that run on the loop's own thread."""

import asyncio
import threading
from collections.abc import Callable

import pytest

from engine.container.executor import NodeExecutor
from engine.container.short_jobs import SHORT, ShortJobs
from ppaas.errors import NoValidPath
from tests.support.waiting import until

Cancelled = Callable[[], bool]


class Clock:
    """Clock that the test advances."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def never() -> bool:
    return False


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def jobs(clock: Clock) -> ShortJobs:
    """Return a runner whose last job was short."""
    made = ShortJobs(clock)
    made.timed(lambda cancelled: None, never)
    return made


async def test_job_after_a_short_one_runs_on_the_loop(jobs: ShortJobs) -> None:
    outcome = jobs.attempt(lambda cancelled: threading.get_ident(), never)
    assert outcome is not None and outcome.result == threading.get_ident()


async def test_first_job_does_not_run_on_the_loop(clock: Clock) -> None:
    assert ShortJobs(clock).attempt(lambda cancelled: 1, never) is None


async def test_job_error_is_its_outcome(jobs: ShortJobs) -> None:
    def fail(cancelled: Cancelled) -> None:
        raise NoValidPath("no way")

    outcome = jobs.attempt(fail, never)
    assert outcome is not None and isinstance(outcome.error, NoValidPath)


async def test_job_that_takes_too_long_is_stopped_and_the_next_deferred(jobs: ShortJobs, clock: Clock) -> None:
    answers: list[bool] = []

    def work(cancelled: Cancelled) -> None:
        answers.append(cancelled())
        clock.now += 2 * SHORT
        answers.append(cancelled())

    assert jobs.attempt(work, never) is None
    assert answers == [False, True]
    await asyncio.sleep(0)
    assert jobs.attempt(lambda cancelled: 1, never) is None
    assert jobs.timed(lambda cancelled: 1, never).result == 1
    assert jobs.attempt(lambda cancelled: 1, never) is not None


async def test_cancelled_job_sees_its_cancellation(jobs: ShortJobs) -> None:
    outcome = jobs.attempt(lambda cancelled: cancelled(), lambda: True)
    assert outcome is not None and outcome.result is True


async def test_only_one_job_runs_in_an_iteration_of_the_loop(jobs: ShortJobs) -> None:
    assert jobs.attempt(lambda cancelled: 1, never) is not None
    assert jobs.attempt(lambda cancelled: 1, never) is None
    await asyncio.sleep(0)
    assert jobs.attempt(lambda cancelled: 1, never) is not None


async def test_executor_restarts_a_long_job_in_a_thread() -> None:
    home = NodeExecutor(lambda: None)
    ends: list[object] = []
    home.graph.start(lambda cancelled: "short", ends.append)
    await until(lambda: ends == ["short"])
    threads: list[int] = []

    def work(cancelled: Cancelled) -> str:
        threads.append(threading.get_ident())
        while threading.get_ident() == threads[0] and not cancelled():
            pass
        return "long"

    home.graph.start(work, ends.append)
    await until(lambda: ends == ["short", "long"])
    assert threads[0] == threading.get_ident() != threads[1]
    home.close()


async def test_executor_restarts_a_waiting_job_in_a_thread() -> None:
    home = NodeExecutor(lambda: None)
    here, threads = threading.get_ident(), list[int]()

    def work(cancelled: Cancelled) -> int:
        threads.append(threading.get_ident())
        if threads[-1] == here:
            home.elsewhere()
        return len(threads)

    results: list[object] = []
    home.graph.start(lambda cancelled: None, results.append)
    await until(lambda: results == [None])
    home.graph.start(work, results.append)
    await until(lambda: len(results) == 2)
    assert (threads[0], results[1]) == (here, 2)
    assert threads[1] != here
    home.close()
