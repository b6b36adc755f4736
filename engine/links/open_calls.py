"""Open service calls: each ends once, by an answer, a timeout or a failure."""

import asyncio
import itertools
import logging
from collections.abc import Callable, Iterator
from typing import NamedTuple

from ppaas.errors import PPaaSError, Unavailable
from ppaas.listener_faults import ListenerFaults

logger = logging.getLogger(__name__)

Outcome = bytes | PPaaSError
"""Response to a call as JSON, or the error."""

Done = Callable[[Outcome], None]
"""Called with the outcome of a call. An exception of it is logged, and concerns neither the one that answered nor other
calls."""


Complete = Callable[[bytes], bytes]
"""Called with an answer of a client as JSON; returns it with all its fields, or raises ``MalformedMessage``."""


class OpenCall(NamedTuple):
    """Call without an answer yet.

    ``client`` is the number of the client to answer it, 0 for the container. ``complete`` completes its answer.
    """

    service: str
    client: int
    done: Done
    alarm: asyncio.TimerHandle
    complete: Complete | None = None


class OpenCalls:
    """Open calls, by number."""

    def __init__(self) -> None:
        self._numbers = itertools.count(1)
        self._calls: dict[int, OpenCall] = {}
        self._faults = ListenerFaults(logger)

    def __getitem__(self, number: int) -> OpenCall:
        """Return an open call; raises ``KeyError`` if there is no such call."""
        return self._calls[number]

    def __len__(self) -> int:
        """Return the number of open calls."""
        return len(self._calls)

    def __iter__(self) -> Iterator[tuple[int, OpenCall]]:
        """Iterate over a copy of the calls, so that they may end meanwhile."""
        return iter(tuple(self._calls.items()))

    def open(self, service: str, timeout: float, done: Done, client: int = 0, complete: Complete | None = None) -> int:
        """Add a call and return its number.

        Parameters
        ----------
        service : str
            Name of the service.
        timeout : float
            Time after which it ends with ``Unavailable`` [s].
        done : callable
            Called once with the outcome, unless the call is cancelled.
        client : int
            Number of the client to answer it; 0 for the container.
        complete : callable, optional
            Completes the answer of a client.
        """
        number = next(self._numbers)
        alarm = asyncio.get_running_loop().call_later(timeout, self._late, number, service, timeout)
        self._calls[number] = OpenCall(service, client, done, alarm, complete)
        return number

    def give_up(self, number: int) -> OpenCall | None:
        """Cancel a call; return it if it was open."""
        call = self._calls.pop(number, None)
        if call is not None:
            call.alarm.cancel()
        return call

    def end(self, number: int, outcome: Outcome) -> None:
        """End a call with its outcome; ignored if the call is not open."""
        call = self.give_up(number)
        if call is not None:
            self._faults.call(f"the caller of service {call.service!r}", call.done, outcome)

    def fail(self, reason: PPaaSError) -> None:
        """End all calls with an error."""
        for number, _ in self:
            self.end(number, reason)

    def _late(self, number: int, service: str, timeout: float) -> None:
        self.end(number, Unavailable(f"service {service!r} did not answer within {timeout:g} s"))


async def answer_of(begin: Callable[[Done], Callable[[], object]]) -> bytes:
    """Begin a call, wait for its outcome, and return the response as JSON.

    Parameters
    ----------
    begin : callable
        Begins the call, given what is called with its outcome; returns a callable that gives it up.

    Raises
    ------
    PPaaSError
        The error of the call.
    """
    answered: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()

    def done(outcome: Outcome) -> None:
        if isinstance(outcome, PPaaSError):
            answered.set_exception(outcome)
        else:
            answered.set_result(outcome)

    give_up = begin(done)
    try:
        return await answered
    finally:
        give_up()
