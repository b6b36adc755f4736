"""Subscriptions of a client: messages of a topic by callback or by asynchronous iteration."""

import asyncio
from collections import deque
from collections.abc import Callable
from contextlib import ExitStack
from typing import Generic, TypeVar, cast

import msgspec

from ppaas.errors import PPaaSError
from ppaas.messages import Message, decode
from ppaas.wire.names import normalise

M = TypeVar("M", bound=Message)


class TopicSubscription(Generic[M]):
    """Subscription to one topic. Iterate over it with ``async for``, unless it has a callback.

    Parameters
    ----------
    topic : str
        Name of the topic as the user wrote it.
    kind : type of Message
        Message type of the topic.
    callback : callable, optional
        Called with each message on the event loop; must not block.
    queue_size : int
        Messages kept for a slow reader. The oldest are dropped and counted in ``dropped``; 1 keeps only the newest.
    """

    def __init__(
        self, topic: str, kind: type[M], callback: Callable[[M], None] | None = None, queue_size: int = 100
    ) -> None:
        if queue_size < 1:
            raise ValueError(f"queue_size must be 1 or more, not {queue_size}")
        self.topic = topic
        self.kind = kind
        self.dropped = 0
        self._callback = callback
        self._waiting: deque[M] = deque(maxlen=queue_size)
        self._arrived = asyncio.Event()
        self._closed = False
        self._error: PPaaSError | None = None

    def deliver(self, payload: msgspec.Raw) -> None:
        """Deliver a message given as JSON.

        Raises
        ------
        MalformedMessage
            The message is not of the topic's type.
        """
        message = decode(self.kind, payload)
        if self._callback is not None:
            self._callback(message)
            return
        self.dropped += len(self._waiting) == self._waiting.maxlen
        self._waiting.append(message)
        self._arrived.set()

    def close(self, error: PPaaSError | None = None) -> None:
        """End the iteration after the queued messages, by raising the error if there is one."""
        self._closed = True
        self._error = error
        self._arrived.set()

    def __aiter__(self) -> "TopicSubscription[M]":
        return self

    async def __anext__(self) -> M:
        while not self._waiting:
            if self._closed:
                raise self._error or StopAsyncIteration
            self._arrived.clear()
            await self._arrived.wait()
        return self._waiting.popleft()


class SubscriptionRegistry:
    """All subscriptions of a client, by topic."""

    def __init__(self) -> None:
        self._by_topic: dict[str, list[TopicSubscription[Message]]] = {}

    def add(self, subscription: TopicSubscription[M]) -> None:
        """Add a subscription."""
        added = cast(TopicSubscription[Message], subscription)
        self._by_topic.setdefault(normalise(subscription.topic), []).append(added)

    def remove(self, subscription: TopicSubscription[M]) -> bool:
        """Close and remove a subscription; return whether it was the last one of its topic."""
        name = normalise(subscription.topic)
        left = [other for other in self._by_topic.get(name, []) if other is not subscription]
        subscription.close()
        if left:
            self._by_topic[name] = left
            return False
        return self._by_topic.pop(name, None) is not None

    def deliver(self, topic: str, payload: msgspec.Raw) -> None:
        """Deliver a message given as JSON to all subscriptions of a topic, also if one of them fails.

        Raises
        ------
        MalformedMessage
            The message is not of the type of a subscription.
        Exception
            The last exception of a callback.
        """
        with ExitStack() as rest:  # it calls all, in the reverse order
            for subscription in reversed(self._by_topic.get(normalise(topic), ())):
                rest.callback(subscription.deliver, payload)

    def close(self, error: PPaaSError | None) -> None:
        """Close and remove all subscriptions; their readers get the error if there is one."""
        for subscriptions in self._by_topic.values():
            for subscription in subscriptions:
                subscription.close(error)
        self._by_topic.clear()
