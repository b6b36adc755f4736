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
        number = next(self._numbers)
        future: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()
        self._calls[number] = future
        send(link.Call(number, service, payload))
        try:
            async with asyncio.timeout(timeout):
                return await future
        except TimeoutError as error:
            raise Unavailable(f"service {service!r} did not answer within {timeout:g} s") from error
        finally:
            self._calls.pop(number, None)

    def answered(self, answer: link.Answer) -> None:
        """Take the answer to a call; one that nobody waits for any more is dropped."""
        future = self._calls.pop(answer.call, None)
        if future is None or future.done():
            return
        if answer.refusal is None:
            future.set_result(answer.payload)
        else:
            future.set_exception(rebuild(answer.refusal.slug, answer.refusal.text))

    def fail(self, reason: PPaaSError) -> None:
        """End all calls with an error."""
        for future in self._calls.values():
            if not future.done():
                future.set_exception(reason)
        self._calls.clear()
