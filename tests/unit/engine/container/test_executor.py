"""Node executor of the cloud, with real threads for its jobs and timers on a real loop."""

import asyncio
import sys
import threading
from collections.abc import AsyncIterator, Callable
from typing import Any

import pytest

from engine.container.executor import JOB_THREADS, LONG_JOB_THREADS, SHORT, NodeExecutor, ShortJobs
from engine.container.kernel_gate import KernelGate
from ppaas.errors import NoValidPath, PPaaSError, Starting
from ppaas.nodes.jobs import TURN, LongWork
from tests.support.waiting import patience, until


@pytest.fixture
async def home() -> AsyncIterator[NodeExecutor]:
    made = NodeExecutor(lambda: None)
    yield made
    made.close()


class Results:
    """Records results of jobs, and the threads on which they were reported."""

    def __init__(self) -> None:
        self.values: list[Any] = []
        self.threads: set[int] = set()

    def __call__(self, result: Any) -> None:
        self.values.append(result)
        self.threads.add(threading.get_ident())


def raising(error: Exception) -> Any:
    def work(cancelled: Any) -> None:
        raise error

    return work


async def test_job_runs_in_a_prepared_thread_and_reports_on_the_loop() -> None:
    prepared: list[int] = []
    home, results = NodeExecutor(lambda: prepared.append(threading.get_ident())), Results()
    go = threading.Event()
    for _ in range(2 * JOB_THREADS):
        home.graph.start(lambda cancelled: go.wait(10) and threading.get_ident(), results)
    go.set()
    await until(lambda: len(results.values) == 2 * JOB_THREADS)
    assert set(results.values) <= set(prepared)
    assert threading.get_ident() not in prepared
    assert results.threads == {threading.get_ident()}
    home.close()


async def test_long_work_never_runs_on_the_loop(home: NodeExecutor) -> None:
    results, before = Results(), sys.getswitchinterval()
    try:
        for _ in range(3):  # after a short job, the next would be tried on the loop
            home.graph.start(LongWork(lambda cancelled: threading.get_ident()), results)
            done = len(results.values) + 1
            await until(lambda done=done: len(results.values) >= done)
        assert threading.get_ident() not in results.values
        assert results.threads == {threading.get_ident()}
        assert sys.getswitchinterval() == pytest.approx(TURN)
    finally:
        sys.setswitchinterval(before)


async def test_plans_do_not_wait_for_long_work(home: NodeExecutor) -> None:
    go, long, results = threading.Event(), Results(), Results()
    before = sys.getswitchinterval()
    try:
        for _ in range(LONG_JOB_THREADS + 1):
            home.graph.start(LongWork(lambda cancelled: go.wait(10)), long)
        home.graph.start(lambda cancelled: "plan", results)
        await until(lambda: results.values == ["plan"])
        assert long.values == []
    finally:
        go.set()
        sys.setswitchinterval(before)
    await until(lambda: long.values == [True] * (LONG_JOB_THREADS + 1))


async def test_job_error_is_its_result(home: NodeExecutor, caplog: pytest.LogCaptureFixture) -> None:
    results = Results()
    home.graph.start(raising(NoValidPath("no way")), results)
    await until(lambda: results.values)
    assert isinstance(results.values[0], NoValidPath)
    assert caplog.records == []


async def test_unexpected_job_error_is_logged_and_reported_without_details(
    home: NodeExecutor, caplog: pytest.LogCaptureFixture
) -> None:
    results = Results()
    home.graph.start(raising(KeyError("secret")), results)
    await until(lambda: results.values)
    (error,) = results.values
    assert type(error) is PPaaSError
    assert str(error) == "internal error: KeyError"
    own = [record for record in caplog.records if record.name == "engine.container.executor"]
    assert [record.exc_info is not None for record in own] == [True]


async def test_job_sees_its_cancellation(home: NodeExecutor) -> None:
    results = Results()

    def work(cancelled: Any) -> str:
        while not cancelled():
            pass
        return "cancelled"

    home.graph.start(work, results).cancel()
    await until(lambda: results.values == ["cancelled"])


async def test_timers_fire_repeatedly(home: NodeExecutor) -> None:
    fired: list[None] = []
    home.graph.every(0.001, lambda: fired.append(None))
    home.attend()
    await until(lambda: len(fired) >= 5)


async def test_timer_set_at_the_end_of_a_job_fires(home: NodeExecutor) -> None:
    fired = asyncio.Event()

    def done(_: Any) -> None:
        home.graph.every(0.001, fired.set)

    home.graph.start(lambda cancelled: None, done)
    async with patience(10):
        await fired.wait()


async def test_timer_set_before_a_job_callback_fails_still_fires(home: NodeExecutor) -> None:
    fired = asyncio.Event()
    contexts: list[dict[str, Any]] = []
    asyncio.get_running_loop().set_exception_handler(lambda _loop, context: contexts.append(context))

    def done(_: Any) -> None:
        home.graph.every(0.001, fired.set)
        raise KeyError("done")

    home.graph.start(lambda cancelled: None, done)
    async with patience(10):
        await fired.wait()
    assert isinstance(contexts[0]["exception"], KeyError)


async def test_failing_timer_is_logged_once_and_all_timers_go_on(
    home: NodeExecutor, caplog: pytest.LogCaptureFixture
) -> None:
    failed: list[None] = []
    fired: list[None] = []

    def fail() -> None:
        failed.append(None)
        raise KeyError("timer")

    home.graph.every(0.002, fail)
    home.graph.every(0.002, lambda: fired.append(None))
    home.attend()
    await until(lambda: len(failed) >= 3 and len(fired) >= 3)
    assert len(caplog.records) == 1


async def test_closed_executor_fires_no_timer_and_reports_no_job(
    home: NodeExecutor, caplog: pytest.LogCaptureFixture
) -> None:
    go, results = threading.Event(), Results()
    fired: list[None] = []
    home.graph.every(0.001, lambda: fired.append(None))
    home.attend()
    for _ in range(2 * JOB_THREADS):  # half of them are queued, and are cancelled
        home.graph.start(lambda cancelled: go.wait(10), results)
    home.close()
    count = len(fired)
    home.attend()
    home.graph.start(lambda cancelled: None, results)
    go.set()
    home._executor.shutdown(wait=True)
    await asyncio.sleep(0.02)
    assert len(fired) == count
    assert results.values == []
    assert caplog.records == []


def test_job_may_outlive_the_loop(caplog: pytest.LogCaptureFixture) -> None:
    go, results = threading.Event(), Results()
    homes: list[NodeExecutor] = []

    async def live() -> None:
        homes.append(NodeExecutor(lambda: None))
        homes[0].graph.start(lambda cancelled: go.wait(10), results)
        homes[0].close()

    asyncio.run(live())
    go.set()
    homes[0]._executor.shutdown(wait=True)
    assert results.values == []
    assert caplog.records == []


class _Compiling(KernelGate):
    """A gate whose kernels the test compiles."""

    def __init__(self) -> None:
        super().__init__()
        self.lacks = ["lattice"]
        self.opened = asyncio.Event()
        self.refusal: Starting | None = None

    def missing(self) -> list[str]:
        return self.lacks

    async def for_job(self) -> None:
        await self.opened.wait()
        if self.refusal is not None:
            raise self.refusal
        self.lacks = []


async def test_a_job_whose_kernels_are_being_compiled_begins_when_they_are() -> None:
    gate, results = _Compiling(), Results()
    home = NodeExecutor(lambda: None, gate)
    began: list[bool] = []
    home.graph.start(lambda cancelled: began.append(gate.opened.is_set()), results)
    await asyncio.sleep(0)
    assert began == []
    gate.opened.set()
    await until(lambda: len(results.values) == 1)
    assert (began, results.values) == ([True], [None])
    home.close()


async def test_a_job_whose_kernels_take_too_long_ends_with_the_reason() -> None:
    gate, results = _Compiling(), Results()
    home = NodeExecutor(lambda: None, gate)
    gate.refusal = Starting("1 of 8")
    gate.opened.set()
    home.graph.start(lambda cancelled: 1, results)
    await until(lambda: len(results.values) == 1)
    assert results.values == [gate.refusal]
    home.close()


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
