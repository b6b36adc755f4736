"""Bounded queue from Zenoh's threads to the event loop: never blocks the threads, and keeps the newest items."""

import asyncio
import logging
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import Generic, TypeVar

T = TypeVar("T")

logger = logging.getLogger(__name__)

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
