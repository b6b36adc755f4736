"""Calls of services that a container works on."""

import asyncio
import itertools
from collections.abc import Callable

from engine import link
from ppaas.errors import PPaaSError, Unavailable, rebuild


class ContainerCalls:
    """The calls of one place that its container has not answered yet."""

    def __init__(self) -> None:
        self._numbers = itertools.count(1)
        self._calls: dict[int, asyncio.Future[bytes]] = {}

    async def call(self, send: Callable[[link.Call], None], service: str, payload: bytes, timeout: float) -> bytes:
        """Send a call and return its response as JSON.

        Raises
        ------
        Unavailable
            It was not answered in time.
        PPaaSError
            What the service raised, or the reason given to ``fail``.
        """
        number, loop = next(self._numbers), asyncio.get_running_loop()
        future: asyncio.Future[bytes] = loop.create_future()
        self._calls[number] = future
        send(link.Call(number, service, payload))
        late = Unavailable(f"service {service!r} did not answer within {timeout:g} s")
        alarm = loop.call_later(timeout, self._end, number, late)
        try:
            return await future
        finally:
            alarm.cancel()
            self._calls.pop(number, None)

    def answered(self, answer: link.Answer) -> None:
        """Take the answer to a call; one that nobody waits for any more is dropped."""
        outcome = answer.payload if answer.refusal is None else rebuild(answer.refusal.slug, answer.refusal.text)
        self._end(answer.call, outcome)

    def _end(self, number: int, outcome: bytes | PPaaSError) -> None:
        future = self._calls.pop(number, None)
        if future is None or future.done():
            return
        if isinstance(outcome, PPaaSError):
            future.set_exception(outcome)
        else:
            future.set_result(outcome)

    def fail(self, reason: PPaaSError) -> None:
        """End all calls with an error."""
        for number in tuple(self._calls):
            self._end(number, reason)
