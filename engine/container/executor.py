"""Node executor of the cloud: runs a graph on an event loop, and its longer jobs in threads."""

import asyncio
import contextlib
import logging
import sys
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Generic, NamedTuple, TypeVar

from engine.container.kernel_gate import KernelGate
from engine.processes.background import Background
from ppaas.clock import Clock, monotonic
from ppaas.errors import PPaaSError
from ppaas.nodes.graph import Graph
from ppaas.nodes.jobs import TURN, LongWork, Work

T = TypeVar("T")

SHORT = 0.02
"""Time limit of a job on the loop's thread [s]; a robot that stands still and a planning client tolerate this delay."""


class JobOutcome(NamedTuple, Generic[T]):
    """Outcome of a job: its result, or the exception that it raised."""

    result: T | None
    error: Exception | None


def attempt(work: Work[T], cancelled: Callable[[], bool]) -> JobOutcome[T]:
    """Run a job in the calling thread."""
    try:
        return JobOutcome(work(cancelled), None)
    except Exception as error:  # noqa: BLE001  # passed to the caller as the outcome
        return JobOutcome(None, error)


class ShortJobs:
    """Runner of jobs that predicts from the last job whether the next is short; for one event loop.

    Passing a job to a thread and its result back takes two wake-ups, longer than planning many a path. So if the last
    job was short, the next is tried on the loop's thread. If it takes longer than `SHORT`, it is cancelled and run
    again from the beginning, in a thread. Only one job is tried in each iteration of the loop: heartbeats and other
    frames wait for one job at most.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._short = False
        self._free = True
        self._declined = False

    def decline(self) -> None:
        """Drop the outcome of the job being attempted, since it would block; it is run again in a thread."""
        self._declined = True

    def timed(self, work: Work[T], cancelled: Callable[[], bool]) -> JobOutcome[T]:
        """Run a job in the calling thread, and record whether it was short."""
        began = self._clock()
        outcome = attempt(work, cancelled)
        self._short = self._clock() - began < SHORT
        return outcome

    def attempt(self, work: Work[T], cancelled: Callable[[], bool]) -> JobOutcome[T] | None:
        """Run a job here and return its outcome; None if it must run in a thread, or took too long."""
        if not (self._short and self._free):
            return None
        self._free = self._declined = False
        asyncio.get_running_loop().call_soon(self._turned)
        until, late = self._clock() + SHORT, False

        def stop() -> bool:
            nonlocal late
            late = late or self._clock() > until
            return late or cancelled()

        outcome = self.timed(work, stop)
        return None if late or self._declined else outcome

    def _turned(self) -> None:
        self._free = True


logger = logging.getLogger(__name__)

Done = Callable[[T | PPaaSError], None]

JOB_THREADS = 2
"""Number of job threads: one for the robot's plan, one for a plan that an operator requests meanwhile."""

LONG_JOB_THREADS = 3
"""Number of threads for `LongWork`, so that no plan waits for it: one for the loop closures of a map, one for layers of
the map that has grown meanwhile, one for clouds of a 3D map."""


class NodeExecutor:
    """Executor of the timers and jobs of one graph.

    Parameters
    ----------
    prepare_thread : callable
        Called once in each thread that runs jobs, before the first.
    gate : KernelGate, optional
        Holds jobs back whose kernels are being compiled.
    """

    def __init__(self, prepare_thread: Callable[[], None], gate: KernelGate | None = None) -> None:
        self._gate = gate or KernelGate()
        self._held = Background()
        self._loop = asyncio.get_running_loop()
        # Threads are started when they are needed: a clone without long jobs has none for them.
        self._executor = ThreadPoolExecutor(JOB_THREADS, "job", prepare_thread)
        self._long_jobs = ThreadPoolExecutor(LONG_JOB_THREADS, "long-job", prepare_thread)
        self._short_jobs = ShortJobs()
        self._alarm: asyncio.Handle | None = None
        self._attending = False
        self._failure = ""
        self._closed = False
        self.graph = Graph(self._work)

    def _work(self, work: Work[T], cancelled: Callable[[], bool], done: Done[T]) -> None:
        if self._closed:
            return
        if self._gate.missing():
            self._held.run(self._once_compiled(work, cancelled, done))
            return
        # A driving robot must not wait for a job on the loop, and a scan not for the loop closures of a map.
        long = isinstance(work, LongWork)
        if long:
            sys.setswitchinterval(TURN)
        outcome = None if self.graph.busy or long else self._short_jobs.attempt(work, cancelled)
        if outcome is not None:
            self._finish(outcome, done)
            return
        if long:
            future = self._long_jobs.submit(attempt, work, cancelled)
        else:
            future = self._executor.submit(self._short_jobs.timed, work, cancelled)
        future.add_done_callback(lambda ended: self._hand_over(ended, done))

    async def _once_compiled(self, work: Work[T], cancelled: Callable[[], bool], done: Done[T]) -> None:
        """Run a job once its kernels are compiled: its time limits begin then."""
        try:
            await self._gate.for_job()
        except PPaaSError as error:
            self._finish(JobOutcome(None, error), done)
        else:
            self._work(work, cancelled, done)

    def _hand_over(self, future: Future[JobOutcome[T]], done: Done[T]) -> None:
        if not future.cancelled():
            with contextlib.suppress(RuntimeError):  # the loop is closed: no client waits for the result
                self._loop.call_soon_threadsafe(self._finish, future.result(), done)

    def _finish(self, outcome: JobOutcome[T], done: Done[T]) -> None:
        if self._closed:
            return
        result, error = outcome
        try:
            if error is None:
                done(result)  # type: ignore[arg-type]  # there is a result if there is no error
            elif isinstance(error, PPaaSError):
                done(error)
            else:
                logger.error("a job failed", exc_info=error)
                done(PPaaSError(f"internal error: {type(error).__name__}"))
        finally:
            self.attend()

    def elsewhere(self) -> None:
        """Restart the job that runs on the loop's thread in a job thread, since it would block the loop."""
        self._short_jobs.decline()

    def attend(self) -> None:
        """Fire the timers that are due in the next iteration of the loop; call it after anything that may set one.

        Frames written in this iteration are sent before.
        """
        if not (self._closed or self._attending):
            self._attending = True
            self._loop.call_soon(self._attend)

    def _attend(self) -> None:
        """Fire the timers that are due, and schedule the next call.

        A timer that fails stays active, as do the others. A repeated failure is logged once.
        """
        self._attending = False
        if self._closed:
            return
        if self._alarm is not None:
            self._alarm.cancel()
        try:
            next_due = self.graph.run_due()
        except Exception as error:
            if repr(error) != self._failure:
                logger.exception("a timer failed")
            self._failure = repr(error)
            next_due = 0.0  # other timers may be due still
        self._alarm = self._loop.call_later(min(next_due, 3600.0), self._attend)

    def close(self) -> None:
        """Stop the timers; running jobs end by themselves, and their results are dropped."""
        self._closed = True
        if self._alarm is not None:
            self._alarm.cancel()
        for executor in (self._executor, self._long_jobs):
            executor.shutdown(wait=False, cancel_futures=True)
