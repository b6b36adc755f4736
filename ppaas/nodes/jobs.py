"""Jobs and timers of a graph's nodes."""

from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

from ppaas.errors import PPaaSError

T = TypeVar("T")

Work = Callable[[Callable[[], bool]], T]
"""Function of a job. Its argument returns whether the job is cancelled. It may be run again from the beginning."""


TURN = 5e-4
"""Switch interval of the interpreter while long jobs run beside a graph [s]. Each call of a kernel waits that long for
the other thread; with Python's default of 5 ms, some scans waited 30 ms for the loop closures of a map."""


class LongWork(Generic[T]):
    """Function of a job that takes long: an executor never runs it on the graph's thread.

    The executor also sets the interpreter's switch interval to `TURN`, so that the graph's thread waits less for it.

    Parameters
    ----------
    work : callable
        The function.
    """

    def __init__(self, work: Work[T]) -> None:
        self._work = work

    def __call__(self, cancelled: Callable[[], bool]) -> T:
        """Run the function."""
        return self._work(cancelled)


class Worker(Protocol):
    """Runs jobs for an executor: ``work(cancelled)``, in another thread if it is long, then ``done`` in the graph's."""

    def __call__(self, work: Work[T], cancelled: Callable[[], bool], done: Callable[[T | PPaaSError], None]) -> None:
        """Run a job."""
        ...


def run_inline(work: Work[T], cancelled: Callable[[], bool], done: Callable[[T | PPaaSError], None]) -> None:
    """Run a job at once in the calling thread; the worker of tests and single-threaded programs."""
    try:
        result: T | PPaaSError = work(cancelled)
    except PPaaSError as error:
        result = error
    done(result)


class GraphTimer:
    """A timer that fires until it is stopped."""

    def __init__(self, period: float, callback: Callable[[], None]) -> None:
        self.period = period
        self.callback = callback
        self.stopped = False

    def stop(self) -> None:
        """Stop the timer."""
        self.stopped = True


class GraphJob:
    """A running job."""

    def __init__(self) -> None:
        self.cancelled = False

    def cancel(self) -> None:
        """Request cancellation."""
        self.cancelled = True

    def is_cancelled(self) -> bool:
        """Return whether the job was cancelled; passed to the work."""
        return self.cancelled
