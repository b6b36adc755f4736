"""Several callers' work in one transaction: what comes while another commits is committed together after it.

A commit that lasts waits for the disk once, however much is in it. So who were committed together and come again are
waited for a moment, or the first of them would be committed alone while the others wait. Whoever comes alone waits for
nobody.
"""

import threading
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from ppaas.clock import monotonic

PATIENCE, LONGEST = 0.5, 0.01
"""For how much of the time that the last commit took those of it are waited for, and at most [s]: a disk that was slow
once is not to hold up who comes alone."""

Given = TypeVar("Given")
Told = TypeVar("Told")


class _Ticket(Generic[Given, Told]):
    """What one caller gives, and is told when it is committed."""

    def __init__(self, given: Given) -> None:
        self.given = given
        self._turn = threading.Lock()  # an event is made of several, and most callers never wait
        self._turn.acquire()
        self.told: Told
        self.error: BaseException | None = None
        self.over = False

    def wait(self) -> None:
        """Return after the next time that it is woken."""
        self._turn.acquire()

    def wake(self) -> None:
        """Let go on who waits; it is waited for once between two times."""
        self._turn.release()


class GroupCommit(Generic[Given, Told]):
    """Hands what callers give to one of them at a time, all that waits together.

    Parameters
    ----------
    commit : callable
        Commits what several gave, all or nothing; returns what each is told, in their order, or the error that it has
        of its own. What it raises is raised to all of them.
    """

    def __init__(self, commit: Callable[[Sequence[Given]], Sequence[Told | Exception]]) -> None:
        self._commit = commit
        self._lock = threading.Lock()
        self._waiting: list[_Ticket[Given, Told]] = []
        self._led = False
        self._together, self._lasted = 1, 0.0
        self._all_came = threading.Condition(self._lock)

    def submit(self, given: Given) -> Told:
        """Return when it is committed."""
        ticket: _Ticket[Given, Told] = _Ticket(given)
        with self._lock:
            self._waiting.append(ticket)
            if len(self._waiting) == self._together > 1:
                self._all_came.notify()
            first, self._led = not self._led, True
        if not first:
            ticket.wait()
        if not ticket.over:
            self._lead()
        if ticket.error is not None:
            raise ticket.error
        return ticket.told

    def _lead(self) -> None:
        """Commit all that waits, then let the next go on with what came meanwhile: nobody works for others for ever."""
        taken, began = self._taken(), monotonic()
        try:
            for ticket, told in zip(taken, self._commit([ticket.given for ticket in taken]), strict=True):
                if isinstance(told, Exception):
                    ticket.error = told
                else:
                    ticket.told = told
        except BaseException as error:  # noqa: BLE001  # it is raised by each that waits
            for ticket in taken:
                ticket.error = error
        with self._lock:
            self._together, self._lasted = len(taken), monotonic() - began
            self._led = bool(self._waiting)
            following = self._waiting[:1]
        for ticket in taken:
            ticket.over = True
        for ticket in taken + following:
            ticket.wake()

    def _taken(self) -> list[_Ticket[Given, Told]]:
        """Take all that waits, once as many wait as came the last time or are late."""
        with self._lock:
            if len(self._waiting) < self._together:
                patience = min(PATIENCE * self._lasted, LONGEST)
                self._all_came.wait_for(lambda: len(self._waiting) >= self._together, patience)
            taken, self._waiting = self._waiting, []
        return taken
