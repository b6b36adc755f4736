"""Plans made off the node's thread, one after the other: a planner may be asked by one thread at a time."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from ppaas.errors import PlanCancelled, PPaaSError, Unavailable
from ppaas.nodes.base import Context, Job

T = TypeVar("T")

MAX_WAITING = 64
"""Plans that may wait; whoever asks for more is told to come again."""

Work = Callable[[Callable[[], bool]], object]
Done = Callable[[object], None]


@dataclass(slots=True)
class _Ticket:
    work: Work
    done: Done
    job: Job | None = None
    cancelled: bool = False

    def cancel(self) -> None:
        """Ask it to stop; ``done`` is still called, with ``PlanCancelled``."""
        self.cancelled = True
        if self.job is not None:
            self.job.cancel()


class PlannerQueue:
    """Runs the jobs of one set of planners in order.

    Parameters
    ----------
    context : Context
        Of the node that plans.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._waiting: deque[_Ticket] = deque()
        self._running: _Ticket | None = None

    def submit(self, work: Callable[[Callable[[], bool]], T], done: Callable[[T | PPaaSError], None]) -> Job:
        """Run ``work(cancelled)`` when its turn comes; ``done`` gets its result or error on the node's thread.

        Raises
        ------
        Unavailable
            Too many wait already.
        """
        if len(self._waiting) >= MAX_WAITING:
            raise Unavailable(f"{MAX_WAITING} plans are waiting already; try again later")
        ticket = _Ticket(work, done)  # type: ignore[arg-type]
        self._waiting.append(ticket)
        self._next()
        return ticket

    def _next(self) -> None:
        while self._running is None and self._waiting:
            ticket = self._waiting.popleft()
            if ticket.cancelled:
                ticket.done(PlanCancelled("cancelled before its turn came"))
                continue
            self._running = ticket
            self._start(ticket)

    def _start(self, ticket: _Ticket) -> None:
        def done(result: object) -> None:
            self._running = None
            try:
                ticket.done(result)
            finally:
                self._next()

        job = self._context.start(ticket.work, done)
        ticket.job = job
