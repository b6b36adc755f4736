"""Messages that must arrive, from when they are sent until the clone has them in a checkpoint."""

import itertools
from collections import deque
from collections.abc import Iterator

from engine import link
from ppaas.errors import QuotaExceeded

MAX_UNACKNOWLEDGED = 1000
MAX_UNACKNOWLEDGED_BYTES = 64 << 20
"""Messages, and bytes of messages, of one place that are kept until the clone has acknowledged them."""


class Unacknowledged:
    """What one place has sent, and will send again to the next container, in order."""

    def __init__(self) -> None:
        self._sequences = itertools.count(1)
        self._messages: deque[link.Deliver] = deque()
        self._bytes = 0

    def __iter__(self) -> Iterator[link.Deliver]:
        """Iterate over them, oldest first."""
        return iter(self._messages)

    def add(self, topic: str, payload: bytes, client: int) -> link.Deliver:
        """Return a message with the next sequence number, and keep it.

        Raises
        ------
        QuotaExceeded
            Too much waits: the client must slow down.
        """
        size = self._bytes + len(payload)
        if len(self._messages) >= MAX_UNACKNOWLEDGED or size > MAX_UNACKNOWLEDGED_BYTES:
            raise QuotaExceeded(f"{len(self._messages)} messages wait to be acknowledged; wait before sending more")
        self._bytes = size
        deliver = link.Deliver(topic, payload, client, next(self._sequences))
        self._messages.append(deliver)
        return deliver

    def acknowledge(self, sequence: int) -> None:
        """Forget all up to a sequence number."""
        while self._messages and self._messages[0].sequence <= sequence:
            self._bytes -= len(self._messages.popleft().payload)
