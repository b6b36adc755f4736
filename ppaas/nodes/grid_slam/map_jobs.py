"""Jobs of ``grid_slam`` that make the map of a log or of a file; calls that depend on the map wait for them."""

from collections import deque
from collections.abc import Callable
from functools import partial
from typing import TypeVar

from ppaas.errors import PPaaSError
from ppaas.nodes.base import Context
from ppaas.nodes.jobs import LongWork, Work

T = TypeVar("T")


class MapJobs:
    """Runs one job at once, and calls that come meanwhile after it, in their order.

    Parameters
    ----------
    context : Context
        Of the node.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._running = False
        self._waiting: deque[Callable[[], None]] = deque()

    def start(self, work: Work[T], done: Callable[[T | PPaaSError], None]) -> None:
        """Start a job; ``done`` is called with its result in the node's thread. None may be running: see `run`."""
        self._running = True
        self._context.start(LongWork(work), partial(self._finish, done))

    def run(self, call: Callable[[], None]) -> None:
        """Call a function now, or as soon as no job is running. It raises nothing."""
        self._waiting.append(call)
        self._run_waiting()

    def _finish(self, done: Callable[[T | PPaaSError], None], result: T | PPaaSError) -> None:
        self._running = False
        done(result)
        self._run_waiting()

    def _run_waiting(self) -> None:
        while self._waiting and not self._running:
            self._waiting.popleft()()
