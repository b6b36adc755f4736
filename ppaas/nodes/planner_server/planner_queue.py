"""Queue of planning jobs, which run one after the other because a planner may be used by one thread at once."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from ppaas.errors import PlanCancelled, PPaaSError, Unavailable
from ppaas.nodes.base import Context, Job
from ppaas.tracing.spans import carried

T = TypeVar("T")

MAX_WAITING = 64
"""Largest number of waiting plans; further requests are rejected."""

Work = Callable[[Callable[[], bool]], object]
Done = Callable[[object], None]


@dataclass(slots=True)
class _Ticket:
    """Handle of a request. It does not reference the work, which holds a costmap, so that this can be freed."""

    job: Job | None = None
    cancelled: bool = False

    def cancel(self) -> None:
        """Request cancellation; ``done`` is still called, with ``PlanCancelled``."""
        self.cancelled = True
        if self.job is not None:
            self.job.cancel()


class PlannerQueue:
    """Runs the jobs of one set of planners in order.

    Parameters
    ----------
    context : Context
        Context of the node that plans.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._waiting: deque[tuple[_Ticket, Work, Done]] = deque()
        self._running = False

    def submit(self, work: Callable[[Callable[[], bool]], T], done: Callable[[T | PPaaSError], None]) -> Job:
        """Run ``work(cancelled)`` after the jobs before it; ``done`` gets its result or error in the node's thread.

        Raises
        ------
        Unavailable
            Too many jobs are waiting.
        """
        if len(self._waiting) >= MAX_WAITING:
            raise Unavailable(f"{MAX_WAITING} plan requests are already waiting; try again later")
        ticket = _Ticket()
        self._waiting.append((ticket, carried(work), carried(done)))  # type: ignore[arg-type]
        self._next()
        return ticket

    def _next(self) -> None:
        while not self._running and self._waiting:
            ticket, work, done = self._waiting.popleft()
            if ticket.cancelled:
                done(PlanCancelled("cancelled before planning began"))
                continue
            self._running = True
            self._start(ticket, work, done)

    def _start(self, ticket: _Ticket, work: Work, done: Done) -> None:
        def finish(result: object) -> None:
            self._running = False
            try:
                done(result)
            # A reply that fails must not stop the queue.
            finally:
                self._next()

        ticket.job = self._context.start(work, finish)
