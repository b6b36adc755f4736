"""Jobs that are over sooner than a thread would have begun them, run where they were asked for.

To hand a job to a thread and its result back takes two wake-ups, which is more than many a path takes to plan. So a job
is begun on the loop's own thread where the one before was short, and it is told that it is cancelled when it turns out
longer: then it is run again from the beginning, in a thread. Only one in a turn of the loop is run like that, so that
beats, orders and other frames wait for no more than that one.
"""

import asyncio
from collections.abc import Callable
from typing import Generic, NamedTuple, TypeVar

from ppaas.clock import Clock, monotonic
from ppaas.nodes.jobs import Work

T = TypeVar("T")

SHORT = 0.02
"""Seconds; so long a robot that stands and whoever plans may be left without an ear."""


class Outcome(NamedTuple, Generic[T]):
    """What a job returned, or what it raised."""

    result: T | None
    error: Exception | None


class ShortJobs:
    """Says which jobs are short, by the last one. For one event loop.

    Parameters
    ----------
    clock : callable
        Monotonic seconds.
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._short = False
        self._free = True
        self._declined = False

    def decline(self) -> None:
        """Learn from the job that is being attempted that it would wait: it is to be begun again in a thread."""
        self._declined = True

    def timed(self, work: Work[T], cancelled: Callable[[], bool]) -> Outcome[T]:
        """Run a job to its end, in whatever thread, and note how long it took."""
        began = self._clock()
        try:
            outcome = Outcome(work(cancelled), None)
        except Exception as error:  # noqa: BLE001  # whoever asked is told
            outcome = Outcome(None, error)
        self._short = self._clock() - began < SHORT
        return outcome

    def attempt(self, work: Work[T], cancelled: Callable[[], bool]) -> Outcome[T] | None:
        """Run a job here and return its outcome; None if it is not to be run here, or took too long."""
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
