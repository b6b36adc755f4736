"""The way from Zenoh's threads to the event loop: never blocks them, never grows, keeps the newest."""

import asyncio
import logging
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import Generic, TypeVar

T = TypeVar("T")

logger = logging.getLogger(__name__)

BATCH = 64
"""Items taken in one turn of the loop, so that a flood on one key leaves the loop time for the others."""


class Inbox(Generic[T]):
    """Hands items to a callback on the loop.

    Parameters
    ----------
    loop : AbstractEventLoop
        On which the callback is called.
    callback : callable
        Takes one item; what it raises is logged.
    limit : int
        Items that may wait; one more, and the oldest is lost.
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
            with suppress(RuntimeError):  # the loop has ended, and nobody waits any longer
                self._loop.call_soon_threadsafe(self._take)

    def close(self) -> None:
        """Call the callback no more."""
        self._closed = True

    def _take(self) -> None:
        # Before the deque is looked at: what is put from now on wakes us again.
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
                logger.exception("a callback of the fabric failed")
        if self._waiting and not self._awake:
            self._awake = True
            self._loop.call_soon(self._take)
