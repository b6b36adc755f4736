"""Network between robots and traffic node: messages arrive late, or not at all."""

import heapq
from random import Random


class Network:
    """Messages that arrive late or not at all; a later one may arrive before an earlier one.

    Parameters
    ----------
    rng : Random
    delay : float
        Largest delay of a message [s].
    loss : float
        Part of messages that are lost.
    """

    def __init__(self, rng: Random, delay: float = 0.1, loss: float = 0.0) -> None:
        self._rng, self._delay, self._loss = rng, delay, loss
        self._waiting: list[tuple[float, int, object]] = []
        self._count = 0

    def send(self, message: object, now: float) -> None:
        """Send a message at a time [s]."""
        if self._rng.random() >= self._loss:
            self._count += 1
            heapq.heappush(self._waiting, (now + self._rng.uniform(0.0, self._delay), self._count, message))

    def arrived(self, now: float) -> list[object]:
        """Return the messages that have arrived by a time [s], the earliest one first."""
        ready = []
        while self._waiting and self._waiting[0][0] <= now:
            ready.append(heapq.heappop(self._waiting)[2])
        return ready
