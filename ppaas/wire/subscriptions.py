"""Subscriptions of one client to one topic: throttle, queue, and spelling of names and times.

A client dispatches on the string it subscribed with. So several subscriptions with the same string form one *channel*,
which, as in rosbridge, has the lowest of their throttle rates, the longest of their queues, and the strongest of their
compressions.
"""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

import msgspec

from ppaas.errors import PPaaSError
from ppaas.wire.binary.packing import PLAIN, Packing, json_frame
from ppaas.wire.operations import Id

Respell: TypeAlias = Callable[[bytes], bytes]
"""Called with a message as JSON; returns it as the client expects."""

MAX_QUEUE = 1000
"""Limit of the queue of one channel [messages]."""


@dataclass(frozen=True, slots=True)
class Subscription:
    """Options of one subscription.

    Parameters
    ----------
    spelling : str
        Name of the topic as the client spelled it.
    throttle : float
        Least time between two messages [s].
    queue_length : int
        Length of the queue of throttled messages; 0 keeps only the newest message.
    respell : callable, optional
        Spells a message as the client expects.
    fragment_size : int
        Length of messages from which they are sent in fragments [characters]; 0 for never.
    packing : Packing
        Packs the messages as the client asked for.
    """

    spelling: str
    throttle: float = 0.0
    queue_length: int = 0
    respell: Respell | None = None
    fragment_size: int = 0
    packing: Packing = PLAIN


@dataclass(slots=True, eq=False)
class Channel:
    """Messages of a topic for the client, under one spelling of the topic."""

    spelling: str
    throttle: float = 0.0
    respell: Respell | None = None
    packing: Packing = PLAIN
    waiting: deque[bytes] = field(default_factory=deque)
    next_at: float = float("-inf")

    def settle(self, subscriptions: list[Subscription]) -> None:
        """Combine the options of these subscriptions, the newest of which is the last."""
        self.throttle = min(s.throttle for s in subscriptions)
        self.respell = subscriptions[-1].respell
        self.packing = max((s.packing for s in subscriptions), key=lambda packing: packing.rank)
        length = min(max(s.queue_length for s in subscriptions), MAX_QUEUE)
        self.waiting = deque(self.waiting, maxlen=max(length, 1))

    def frame_of(self, payload: bytes) -> bytes:
        """Return the frame of a message; JSON if it cannot be packed otherwise, as a client's message may be."""
        text = payload if self.respell is None else self.respell(payload)
        try:
            return self.packing.pack(self.spelling, text)
        except (PPaaSError, msgspec.MsgspecError, ValueError, RecursionError):
            return json_frame(self.spelling, text)

    def take(self, payload: bytes, now: float) -> bytes | None:
        """Add a message; return the message to send now, or None if it must wait.

        A full queue drops its oldest message. So the last message of a series is always delivered.
        """
        if self.throttle <= 0.0 and not self.waiting:
            return payload
        self.waiting.append(payload)
        return self.due(now)

    def due(self, now: float) -> bytes | None:
        """Return a queued message that is due, if there is one."""
        if not self.waiting or now < self.next_at:
            return None
        self.next_at = now + self.throttle
        return self.waiting.popleft()


class TopicSubscriptions:
    """Subscriptions of one client to one topic."""

    def __init__(self) -> None:
        self._by_id: dict[Id, Subscription] = {}
        self._channels: dict[str, Channel] = {}

    def __len__(self) -> int:
        """Return the number of subscriptions."""
        return len(self._by_id)

    def __iter__(self) -> Iterator[Channel]:
        """Iterate over the channels."""
        return iter(self._channels.values())

    def add(self, subscription_id: Id, subscription: Subscription) -> None:
        """Add a subscription, or replace the one with the same id."""
        self._by_id.pop(subscription_id, None)
        self._by_id[subscription_id] = subscription
        self._settle()

    def remove(self, subscription_id: Id) -> None:
        """Remove the subscription with an id; None removes all."""
        if subscription_id is None:
            self._by_id.clear()
        else:
            self._by_id.pop(subscription_id, None)
        self._settle()

    def _settle(self) -> None:
        by_spelling: dict[str, list[Subscription]] = {}
        for subscription in self._by_id.values():
            by_spelling.setdefault(subscription.spelling, []).append(subscription)
        self._channels = {spelling: self._channels.get(spelling, Channel(spelling)) for spelling in by_spelling}
        for spelling, subscriptions in by_spelling.items():
            self._channels[spelling].settle(subscriptions)

    @property
    def fragment_size(self) -> int:
        """Least size from which messages are sent in fragments [characters]; 0 if there is none."""
        return min((s.fragment_size for s in self._by_id.values() if s.fragment_size), default=0)

    @property
    def queue_length(self) -> int:
        """Longest requested queue [messages]; 0 if none was requested."""
        return max((s.queue_length for s in self._by_id.values()), default=0)
