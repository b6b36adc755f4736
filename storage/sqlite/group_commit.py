"""Group commit: the work of several callers in one transaction.

Work that arrives during a commit is committed together after it, because a commit syncs the disk once, however large it
is. Callers of one group often come again at the same time. The first of them waits a moment for the others, or it would
be committed alone while they wait. A single caller does not wait.
"""

import threading
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from ppaas.clock import monotonic

WAIT_FRACTION, MAX_WAIT = 0.5, 0.01
"""Time to wait for the rest of the last group: a fraction of the duration of the last commit, and an upper bound [s],
so that one slow commit does not delay a single caller."""

Work = TypeVar("Work")
Result = TypeVar("Result")


class _PendingWork(Generic[Work, Result]):
    """The work of one caller, and its result or error once it is committed."""

    def __init__(self, work: Work) -> None:
        self.work = work
        self._turn = threading.Lock()  # cheaper than an event, and most callers never wait
        self._turn.acquire()
        self.result: Result
        self.error: BaseException | None = None
        self.done = False

    def wait(self) -> None:
        """Block until the next ``wake``."""
        self._turn.acquire()

    def wake(self) -> None:
        """Wake the caller, which is waiting or will wait; ``wait`` and ``wake`` alternate."""
        self._turn.release()


class GroupCommit(Generic[Work, Result]):
    """Lets one of the waiting callers at a time, the leader, commit the work of all.

    Parameters
    ----------
    commit : callable
        Commits the work of several callers, all or nothing; returns, in order, the result of each, or the error of
        its work alone. An error that it raises is raised to all of them.
    """

    def __init__(self, commit: Callable[[Sequence[Work]], Sequence[Result | Exception]]) -> None:
        self._commit = commit
        self._lock = threading.Lock()
        self._waiting: list[_PendingWork[Work, Result]] = []
        self._has_leader = False
        self._last_size, self._last_duration = 1, 0.0
        self._group_complete = threading.Condition(self._lock)

    def submit(self, work: Work) -> Result:
        """Return the result after the work has been committed; raise its error."""
        pending: _PendingWork[Work, Result] = _PendingWork(work)
        with self._lock:
            self._waiting.append(pending)
            if len(self._waiting) == self._last_size > 1:
                self._group_complete.notify()
            leads, self._has_leader = not self._has_leader, True
        if not leads:
            pending.wait()
        if not pending.done:
            self._lead()
        if pending.error is not None:
            raise pending.error
        return pending.result

    def _lead(self) -> None:
        """Commit all waiting work, then pass the lead to a caller that arrived meanwhile, so nobody leads for ever."""
        group, began = self._take_group(), monotonic()
        try:
            for pending, result in zip(group, self._commit([pending.work for pending in group]), strict=True):
                if isinstance(result, Exception):
                    pending.error = result
                else:
                    pending.result = result
        except BaseException as error:  # noqa: BLE001  # raised to each caller of the group
            for pending in group:
                pending.error = error
        with self._lock:
            self._last_size, self._last_duration = len(group), monotonic() - began
            self._has_leader = bool(self._waiting)
            next_leader = self._waiting[:1]
        for pending in group:
            pending.done = True
        for pending in group + next_leader:
            pending.wake()

    def _take_group(self) -> list[_PendingWork[Work, Result]]:
        """Take all waiting work, once it is as much as the last group, or the time to wait for that is over."""
        with self._lock:
            if len(self._waiting) < self._last_size:
                timeout = min(WAIT_FRACTION * self._last_duration, MAX_WAIT)
                self._group_complete.wait_for(lambda: len(self._waiting) >= self._last_size, timeout)
            group, self._waiting = self._waiting, []
        return group
