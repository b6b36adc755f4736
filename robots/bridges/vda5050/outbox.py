"""Messages that wait for the broker: bounded, in order, and none older than needed."""

import asyncio
from collections import OrderedDict
from dataclasses import dataclass

from ppaas.errors import Unavailable


@dataclass(frozen=True, slots=True)
class Outgoing:
    """Message for the broker: topic, payload, quality of service, and whether the broker retains it."""

    topic: str
    payload: bytes
    qos: int = 0
    retain: bool = False


class Outbox:
    """Queue of messages.

    Parameters
    ----------
    capacity : int
        Largest number of messages that wait.
    """

    def __init__(self, capacity: int = 1000) -> None:
        self._capacity = capacity
        self._waiting: OrderedDict[str, Outgoing] = OrderedDict()
        self._number = 0
        self._filled = asyncio.Event()
        self.dropped = 0

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, message: Outgoing) -> None:
        """Queue a message that must not be lost.

        Raises
        ------
        Unavailable
            The queue is full: the broker has been away for long.
        """
        if len(self._waiting) >= self._capacity:
            raise Unavailable(f"{len(self._waiting)} messages wait for the MQTT broker: check that it can be reached")
        self._number += 1
        self._add(f"#{self._number}", message)  # no topic begins with '#'

    def put_newest(self, message: Outgoing) -> None:
        """Queue a message in place of a waiting one of its topic; drop it if the queue is full of others."""
        if self._waiting.pop(message.topic, None) is not None or len(self._waiting) >= self._capacity:
            self.dropped += 1
        if len(self._waiting) < self._capacity:
            self._add(message.topic, message)

    def put_back(self, message: Outgoing) -> None:
        """Queue a message that was taken out and not sent before all others; a newer one of its topic replaces it."""
        if message.topic not in self._waiting and len(self._waiting) < self._capacity:
            self._number += 1
            self._add(f"#{self._number}", message)
            self._waiting.move_to_end(f"#{self._number}", last=False)

    def _add(self, key: str, message: Outgoing) -> None:
        self._waiting[key] = message
        self._filled.set()

    async def next(self) -> Outgoing:
        """Wait for the next message, and take it out of the queue."""
        while not self._waiting:
            self._filled.clear()
            await self._filled.wait()
        return self._waiting.popitem(last=False)[1]
