"""Shared positions: what the robots of one map share, received once for a machine and passed on in batches.

With n robots on a map, each position is for n - 1 containers. In batches, a container is woken ten times a second
whatever n is, and a frame is encoded once for all of them.
"""

import asyncio
import itertools
from collections.abc import Callable
from typing import Protocol

from engine.fabric.keys import Scope, parse_shared
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream, pack
from ppaas.clock import monotonic

PERIOD = 0.1
"""Smallest time between two batches [s]; a robot shares its position at most five times a second."""

MAX_WAITING = 1 << 18
"""Bytes queued for a slow container above which shared messages to it are dropped."""

MAX_BATCH = 1 << 16
"""Size of all messages of a batch above which it is not delayed [bytes]."""

Stream = FrameStream[machine_link.FromContainer]


class Subscription(Protocol):
    """Subscription to a key expression."""

    def close(self) -> None:
        """End it."""
        ...


Subscribe = Callable[[Callable[[str, bytes], None]], Subscription]
"""Subscribes to a key expression, with a callback for key and payload."""


class SharedPositions:
    """Messages on one key expression, for all containers of this machine that receive them.

    The first message after a pause is passed on at once. Of several messages of a robot in one batch, the last is
    passed on. A batch is the same for all containers, so a robot finds its own message in it.

    Parameters
    ----------
    subscribe : callable
        Subscribes to the key expression, while a container receives it.
    """

    def __init__(self, subscribe: Subscribe) -> None:
        self._subscribe = subscribe
        self._subscription: Subscription | None = None
        self._numbers = itertools.count()
        self._hearers: dict[int, tuple[Scope, Stream]] = {}
        self._waiting: dict[tuple[str, str], machine_link.Shared] = {}
        self._size = 0
        self._passed_at = float("-inf")
        self._timer: asyncio.TimerHandle | None = None

    def add(self, scope: Scope, stream: Stream) -> Callable[[], None]:
        """Pass messages on to a container; return a function that ends it."""
        number = next(self._numbers)
        self._hearers[number] = scope, stream
        if self._subscription is None:
            self._subscription = self._subscribe(self._heard)
        return lambda: self._drop(number)

    def _drop(self, number: int) -> None:
        self._hearers.pop(number, None)
        if not self._hearers and self._subscription is not None:
            self._subscription.close()
            self._subscription = None
            self._begin_batch()

    def _begin_batch(self) -> list[machine_link.Shared]:
        """Return the messages that wait, and begin another batch."""
        batch, self._size = [*self._waiting.values()], 0
        self._waiting.clear()
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        return batch

    def _heard(self, key: str, payload: bytes) -> None:
        other = parse_shared(key)
        self._waiting[other.user, other.robot] = machine_link.Shared(other.user, other.robot, other.topic, payload)
        self._size += len(payload)
        pause = self._passed_at + PERIOD - monotonic()
        if pause <= 0.0 or self._size > MAX_BATCH:
            self._pass_on()
        elif self._timer is None:
            self._timer = asyncio.get_running_loop().call_later(pause, self._pass_on)

    def _pass_on(self) -> None:
        batch, self._passed_at = self._begin_batch(), monotonic()
        ready = [(scope, stream) for scope, stream in self._hearers.values() if stream.waiting <= MAX_WAITING]
        if len(batch) > 1:
            frame = pack(machine_link.SharedBatch(batch))
            for _, stream in ready:
                stream.write_packed(frame)
            return
        for message in batch:
            for scope, stream in ready:
                if (message.user, message.robot) != (scope.user, scope.robot):
                    stream.write(message)
