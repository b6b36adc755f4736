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
    """What who asked keeps: of the work itself, which holds a costmap, nothing stays once it is done."""

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
        self._waiting: deque[tuple[_Ticket, Work, Done]] = deque()
        self._running = False

    def submit(self, work: Callable[[Callable[[], bool]], T], done: Callable[[T | PPaaSError], None]) -> Job:
        """Run ``work(cancelled)`` when its turn comes; ``done`` gets its result or error on the node's thread.

        Raises
        ------
        Unavailable
            Too many wait already.
        """
        if len(self._waiting) >= MAX_WAITING:
            raise Unavailable(f"{MAX_WAITING} plans are waiting already; try again later")
        ticket = _Ticket()
        self._waiting.append((ticket, work, done))  # type: ignore[arg-type]
        self._next()
        return ticket

    def _next(self) -> None:
        while not self._running and self._waiting:
            ticket, work, done = self._waiting.popleft()
            if ticket.cancelled:
                done(PlanCancelled("cancelled before its turn came"))
                continue
            self._running = True
            self._start(ticket, work, done)

    def _start(self, ticket: _Ticket, work: Work, done: Done) -> None:
        def finish(result: object) -> None:
            self._running = False
            try:
                done(result)
            finally:
                self._next()

        ticket.job = self._context.start(work, finish)
