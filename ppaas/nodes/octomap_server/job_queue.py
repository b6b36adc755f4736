"""Queue of jobs that run one after the other."""

from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple, TypeVar

from ppaas.errors import PPaaSError
from ppaas.nodes.base import Context
from ppaas.nodes.jobs import LongWork

T = TypeVar("T")


class _Entry(NamedTuple):
    work: Callable[[], Any]
    done: Callable[[Any], None]
    may_be_dropped: bool


class JobQueue:
    """Runs the jobs of a node in the order in which they are added.

    Parameters
    ----------
    context : Context
        Of the node.
    most : int
        Largest number of jobs that wait and may be dropped; the oldest is.

    Attributes
    ----------
    dropped : int
        Number of jobs that were dropped.
    """

    def __init__(self, context: Context, most: int) -> None:
        self.dropped = 0
        self._context, self._most = context, most
        self._entries: deque[_Entry] = deque()
        self._running = False

    def add(
        self, work: Callable[[], T], done: Callable[[T | PPaaSError], None], *, may_be_dropped: bool = False
    ) -> None:
        """Run ``work``, then ``done`` with its result or error in the node's thread."""
        if may_be_dropped:
            waiting = [entry for entry in self._entries if entry.may_be_dropped]
            if len(waiting) >= self._most:
                self._entries.remove(waiting[0])
                self.dropped += 1
        self._entries.append(_Entry(work, done, may_be_dropped))
        self._start()

    def _start(self) -> None:
        if self._running or not self._entries:
            return
        self._running = True
        entry = self._entries.popleft()
        self._context.start(LongWork(lambda _: entry.work()), partial(self._finish, entry))

    def _finish(self, entry: _Entry, result: Any) -> None:
        self._running = False
        try:
            entry.done(result)
        finally:
            self._start()
