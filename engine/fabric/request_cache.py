"""Cache of requests and their answers, so that a request that arrives twice is executed once."""

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any

from ppaas.clock import Clock, monotonic
from ppaas.errors import Unavailable

MARGIN = 10.0
"""Time for which an answer is kept after the client's timeout [s], for repetitions that are still under way."""

Answering = Coroutine[Any, Any, bytes]


class RequestCache:
    """Requests, executing and answered, by their id.

    An answer is kept while its request may be repeated. When the cache is full, new requests are refused.

    Parameters
    ----------
    limit : int
        Capacity [requests].
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
        """Return the task that executes a request: a new one, or the task of its first arrival.

        Parameters
        ----------
        request : str
            Id of the request.
        patience : float
            Time for which it may be repeated [s].
        begin : callable
            Returns the coroutine that executes it; called only if the request is new.

        Raises
        ------
        Unavailable
            The cache is full.
        """
        now = self._clock()
        if now >= self._next_sweep or len(self._known) >= self._limit:
            self._sweep(now)
        if request in self._known:
            return self._known[request][0]
        if len(self._known) >= self._limit:
            raise Unavailable(f"{self._limit} requests are executing or were just answered; try again later")
        task = asyncio.ensure_future(begin())
        self._known[request] = task, now + patience + MARGIN
        return task

    def _sweep(self, now: float) -> None:
        self._known = {
            request: (task, until) for request, (task, until) in self._known.items() if until > now or not task.done()
        }
        self._next_sweep = now + 1.0

    def cancel(self) -> None:
        """Cancel all executing requests."""
        for task, _ in self._known.values():
            task.cancel()
        self._known.clear()
