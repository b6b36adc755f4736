"""How one client hears one topic: how often, how much waits, in which spelling.

A client dispatches on the string it subscribed with, so several subscriptions with the same string are one *channel*:
as rosbridge has it, messages come at the lowest of their throttle rates, with the longest of their queues.
"""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field

MAX_QUEUE = 1000
"""Messages that one channel may keep for later."""


@dataclass(frozen=True, slots=True)
class Subscription:
    """What one subscription asks for.

    Parameters
    ----------
    spelling : str
        The topic, as the client wrote it.
    throttle : float
        Seconds between two messages.
    queue_length : int
        Messages that wait for their turn; 0 keeps the newest.
    ros2 : bool
        Times are spelled as in ROS 2.
    """

    spelling: str
    throttle: float = 0.0
    queue_length: int = 0
    ros2: bool = False


@dataclass(slots=True, eq=False)
class Channel:
    """What the client is told of a topic under one spelling."""

    spelling: str
    throttle: float = 0.0
    ros2: bool = False
    waiting: deque[bytes] = field(default_factory=deque)
    next_at: float = float("-inf")

    def settle(self, subscriptions: list[Subscription]) -> None:
        """Do as all of these subscriptions, the newest last, can live with."""
        self.throttle = min(s.throttle for s in subscriptions)
        self.ros2 = subscriptions[-1].ros2
        length = min(max(s.queue_length for s in subscriptions), MAX_QUEUE)
        self.waiting = deque(self.waiting, maxlen=max(length, 1))

    def take(self, payload: bytes, now: float) -> bytes | None:
        """Return what is to be sent now that a message came; None if it waits for its turn.

        What waits is at most what the queue holds: the newest take the place of the oldest, so the last message of all
        is never lost only because it came too soon.
        """
        if self.throttle <= 0.0 and not self.waiting:
            return payload
        self.waiting.append(payload)
        return self.due(now)

    def due(self, now: float) -> bytes | None:
        """Return a message whose turn has come, if there is one."""
        if not self.waiting or now < self.next_at:
            return None
        self.next_at = now + self.throttle
        return self.waiting.popleft()


class TopicSubscriptions:
    """The subscriptions of one client to one topic."""

    def __init__(self) -> None:
        self._by_id: dict[str | None, Subscription] = {}
        self._channels: dict[str, Channel] = {}

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._by_id)

    def __iter__(self) -> Iterator[Channel]:
        """Iterate over the channels."""
        return iter(self._channels.values())

    def add(self, subscription_id: str | None, subscription: Subscription) -> None:
        """Add a subscription; one of the same id is changed by it."""
        self._by_id.pop(subscription_id, None)
        self._by_id[subscription_id] = subscription
        self._settle()

    def remove(self, subscription_id: str | None) -> None:
        """Remove the subscription of an id; None removes all."""
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
    def queue_length(self) -> int:
        """The longest queue that was asked for; 0 if none was."""
        return max((s.queue_length for s in self._by_id.values()), default=0)
