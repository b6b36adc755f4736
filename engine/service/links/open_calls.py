"""Calls of services that are under way: each ends once, whatever comes first."""

import asyncio
import itertools
from collections.abc import Callable, Iterator
from typing import NamedTuple

from ppaas.errors import PPaaSError, Unavailable

Outcome = bytes | PPaaSError
"""The response to a call as JSON, or why there is none."""

Done = Callable[[Outcome], None]


class OpenCall(NamedTuple):
    """A call that is not answered yet."""

    service: str
    client: int
    done: Done
    alarm: asyncio.TimerHandle


class OpenCalls:
    """Calls by number."""

    def __init__(self) -> None:
        self._numbers = itertools.count(1)
        self._calls: dict[int, OpenCall] = {}

    def __getitem__(self, number: int) -> OpenCall:
        """Return a call; ``KeyError`` if it is answered, given up or never was."""
        return self._calls[number]

    def __iter__(self) -> Iterator[tuple[int, OpenCall]]:
        """Go through all calls; they may end meanwhile."""
        return iter(tuple(self._calls.items()))

    def open(self, service: str, timeout: float, done: Done, client: int = 0) -> int:
        """Return the number of a new call.

        Parameters
        ----------
        service : str
            Which is called.
        timeout : float
            Seconds until it ends as ``Unavailable``.
        done : callable
            Gets the outcome, once, unless the call is given up.
        client : int
            Who is to answer it, if it is not the container.
        """
        number = next(self._numbers)
        alarm = asyncio.get_running_loop().call_later(timeout, self._late, number, service, timeout)
        self._calls[number] = OpenCall(service, client, done, alarm)
        return number

    def give_up(self, number: int) -> OpenCall | None:
        """Wait for an answer no more; return the call if it was open."""
        call = self._calls.pop(number, None)
        if call is not None:
            call.alarm.cancel()
        return call

    def end(self, number: int, outcome: Outcome) -> None:
        """Give a call its outcome; one that nobody waits for any more is dropped."""
        call = self.give_up(number)
        if call is not None:
            call.done(outcome)

    def fail(self, reason: PPaaSError) -> None:
        """End all calls with an error."""
        for number, _ in self:
            self.end(number, reason)

    def _late(self, number: int, service: str, timeout: float) -> None:
        self.end(number, Unavailable(f"service {service!r} did not answer within {timeout:g} s"))
