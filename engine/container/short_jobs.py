"""Short jobs: run on the event loop's own thread, if they take less time than a thread needs to start.

Passing a job to a thread and its result back takes two wake-ups, longer than planning many a path. So if the last job
was short, the next is tried on the loop's thread. If it takes longer than `SHORT`, it is cancelled and run again from
the beginning, in a thread. Only one job is tried in each iteration of the loop: heartbeats and other frames wait for
one job at most.
"""

import asyncio
from collections.abc import Callable
from typing import Generic, NamedTuple, TypeVar

from ppaas.clock import Clock, monotonic
from ppaas.nodes.jobs import Work

T = TypeVar("T")

SHORT = 0.02
"""Time limit of a job on the loop's thread [s]; a robot that stands still and a planning client tolerate this delay."""


class Outcome(NamedTuple, Generic[T]):
    """Outcome of a job: its result, or the exception that it raised."""

    result: T | None
    error: Exception | None


def attempt(work: Work[T], cancelled: Callable[[], bool]) -> Outcome[T]:
    """Run a job in the calling thread."""
    try:
        return Outcome(work(cancelled), None)
    except Exception as error:  # noqa: BLE001  # passed to the caller as the outcome
        return Outcome(None, error)


class ShortJobs:
    """Runner of jobs that predicts from the last job whether the next is short; for one event loop.

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

    def timed(self, work: Work[T], cancelled: Callable[[], bool]) -> Outcome[T]:
        """Run a job in the calling thread, and record whether it was short."""
        began = self._clock()
        outcome = attempt(work, cancelled)
        self._short = self._clock() - began < SHORT
        return outcome

    def attempt(self, work: Work[T], cancelled: Callable[[], bool]) -> Outcome[T] | None:
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
