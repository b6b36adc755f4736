"""Inbox of the fabric: a bounded queue from Zenoh's threads to the event loop, and a cache of answered requests.

The queue never blocks the threads, and keeps the newest items. A request that arrives twice is executed once.
"""

import asyncio
import logging
from collections import deque
from collections.abc import Callable, Coroutine
from contextlib import suppress
from typing import Any, Generic, TypeVar

from ppaas.clock import Clock, monotonic
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

T = TypeVar("T")


# -- queue to the event loop -------------------------------------------------------------------------------------------

BATCH = 64
"""Most items handled in one turn of the loop, so that a flood on one key leaves time for others."""


class Inbox(Generic[T]):
    """Hands items to a callback on the loop.

    Parameters
    ----------
    loop : AbstractEventLoop
        Event loop to call the callback on.
    callback : callable
        Called with one item; its exceptions are logged.
    limit : int
        Capacity of the queue. When it is full, the oldest item is dropped.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, callback: Callable[[T], None], limit: int) -> None:
        self._loop = loop
        self._callback = callback
        self._waiting: deque[T] = deque(maxlen=limit)
        self._awake = False
        self._closed = False

    def put(self, item: T) -> None:
        """Add an item, from any thread."""
        if self._closed:
            return
        self._waiting.append(item)
        if not self._awake:
            self._awake = True
            with suppress(RuntimeError):  # the loop is closed
                self._loop.call_soon_threadsafe(self._take)

    def close(self) -> None:
        """Stop calling the callback."""
        self._closed = True

    def _take(self) -> None:
        # Reset before the queue is read: an item that is added from now on schedules another call.
        self._awake = False
        for _ in range(BATCH):
            if self._closed:
                return
            try:
                item = self._waiting.popleft()
            except IndexError:
                return
            try:
                self._callback(item)
            except Exception:
                logger.exception("a callback of the fabric raised an exception")
        if self._waiting and not self._awake:
            self._awake = True
            self._loop.call_soon(self._take)


# -- requests that arrive twice ----------------------------------------------------------------------------------------

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
