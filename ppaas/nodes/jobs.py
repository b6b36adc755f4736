"""What a graph runs for its nodes: jobs, which a home does elsewhere if they are long, and timers."""

from collections.abc import Callable
from typing import Protocol, TypeVar

from ppaas.errors import PPaaSError

T = TypeVar("T")

Work = Callable[[Callable[[], bool]], T]
"""What a job does; it asks now and then whether it is cancelled, and may be run again from the beginning."""


class Worker(Protocol):
    """How a home runs jobs: ``work(cancelled)``, elsewhere if it is long, then ``done`` on the thread of the graph."""

    def __call__(self, work: Work[T], cancelled: Callable[[], bool], done: Callable[[T | PPaaSError], None]) -> None:
        """Run it."""
        ...


def run_inline(work: Work[T], cancelled: Callable[[], bool], done: Callable[[T | PPaaSError], None]) -> None:
    """Be the worker of tests and of programs with one thread: run the job here and now."""
    try:
        result: T | PPaaSError = work(cancelled)
    except PPaaSError as error:
        result = error
    done(result)


class GraphTimer:
    """A timer; ``stop`` it when it is no longer needed."""

    def __init__(self, period: float, callback: Callable[[], None]) -> None:
        self.period = period
        self.callback = callback
        self.stopped = False

    def stop(self) -> None:
        """Fire no more."""
        self.stopped = True


class GraphJob:
    """Work under way."""

    def __init__(self) -> None:
        self.cancelled = False

    def cancel(self) -> None:
        """Ask it to stop."""
        self.cancelled = True

    def is_cancelled(self) -> bool:
        """Be the cancel checker that the work is given."""
        return self.cancelled
