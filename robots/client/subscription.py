"""What a client hears on one topic: by a callback, or one message after the other."""

import asyncio
from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

import msgspec

from ppaas.errors import PPaaSError
from ppaas.messages import Message, decode

M = TypeVar("M", bound=Message)


class Subscription(Generic[M]):
    """Messages of one topic; iterate over it with ``async for``, unless it was given a callback.

    Parameters
    ----------
    topic : str
        As it was asked for.
    kind : type of Message
        What it carries.
    callback : callable, optional
        Called with each message, on the event loop; it must not block.
    queue_size : int
        Messages kept for a reader that is slow; the oldest are dropped and counted. 1 keeps only the newest.
    """

    def __init__(
        self, topic: str, kind: type[M], callback: Callable[[M], None] | None = None, queue_size: int = 100
    ) -> None:
        if queue_size < 1:
            raise ValueError(f"a subscription keeps one message or more, not {queue_size}")
        self.topic = topic
        self.kind = kind
        self.dropped = 0
        self._callback = callback
        self._waiting: deque[M] = deque(maxlen=queue_size)
        self._arrived = asyncio.Event()
        self._closed = False
        self._error: PPaaSError | None = None

    def deliver(self, payload: msgspec.Raw) -> None:
        """Take a message as JSON.

        Raises
        ------
        MalformedMessage
            It is not of the topic's type.
        """
        message = decode(self.kind, payload)
        if self._callback is not None:
            self._callback(message)
            return
        self.dropped += len(self._waiting) == self._waiting.maxlen
        self._waiting.append(message)
        self._arrived.set()

    def close(self, error: PPaaSError | None = None) -> None:
        """End the iteration, after what still waits; with an error if there was one."""
        self._closed = True
        self._error = error
        self._arrived.set()

    def __aiter__(self) -> "Subscription[M]":
        return self

    async def __anext__(self) -> M:
        while not self._waiting:
            if self._closed:
                raise self._error or StopAsyncIteration
            self._arrived.clear()
            await self._arrived.wait()
        return self._waiting.popleft()
