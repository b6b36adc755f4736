"""What a server remembers of requests, so that one that comes twice is carried out once."""

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any

from ppaas.clock import Clock, monotonic
from ppaas.errors import Unavailable

MARGIN = 10.0
"""Seconds for which an answer is kept beyond the patience of whoever asks, for a repetition still on its way."""

Answering = Coroutine[Any, Any, bytes]


class RequestCache:
    """Requests under way and answered, by their id.

    Nothing is forgotten that may still be asked for: where there is no room, a new request is refused instead.

    Parameters
    ----------
    limit : int
        Most requests that are remembered.
    clock : callable
        Monotonic seconds.
    """

    def __init__(self, limit: int = 20_000, clock: Clock = monotonic) -> None:
        self._limit = limit
        self._clock = clock
        self._known: dict[str, tuple[asyncio.Task[bytes], float]] = {}
        self._next_sweep = 0.0

    def __len__(self) -> int:
        return len(self._known)

    def answer(self, request: str, patience: float, begin: Callable[[], Answering]) -> asyncio.Task[bytes]:
        """Return the task that answers a request: a new one, or that of its first arrival.

        Parameters
        ----------
        request : str
            Its id.
        patience : float
            Seconds for which it may be repeated.
        begin : callable
            Starts to carry it out; called only if the request is new.

        Raises
        ------
        Unavailable
            Too many requests are remembered.
        """
        now = self._clock()
        if now >= self._next_sweep or len(self._known) >= self._limit:
            self._sweep(now)
        if request in self._known:
            return self._known[request][0]
        if len(self._known) >= self._limit:
            raise Unavailable(f"{self._limit} requests are under way or were just answered; try again later")
        task = asyncio.ensure_future(begin())
        self._known[request] = task, now + patience + MARGIN
        return task

    def _sweep(self, now: float) -> None:
        self._known = {
            request: (task, until) for request, (task, until) in self._known.items() if until > now or not task.done()
        }
        self._next_sweep = now + 1.0

    def cancel(self) -> None:
        """Stop carrying out what is under way."""
        for task, _ in self._known.values():
            task.cancel()
        self._known.clear()
