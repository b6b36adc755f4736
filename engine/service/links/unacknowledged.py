"""Messages that must arrive, from when they are sent until the clone has them in a checkpoint."""

import itertools
from collections import deque
from collections.abc import Iterator

import msgspec

from engine.protocols import robot_link
from ppaas.errors import QuotaExceeded

MAX_UNACKNOWLEDGED = 1000
MAX_UNACKNOWLEDGED_BYTES = 64 << 20
"""Messages, and bytes of messages, of one place that are kept until the clone has acknowledged them."""


class Unacknowledged:
    """What one place has sent, and will send again to the next container, in order.

    The first container that a place sees may have been served by another cloud process: the numbers go on from the
    last that it took. What is before that, as a message that waited for it, has its own number until then.
    """

    def __init__(self) -> None:
        self._sequences = itertools.count(1)
        self._before: int | None = None
        self._messages: deque[robot_link.Deliver] = deque()
        self._bytes = 0

    def __iter__(self) -> Iterator[robot_link.Deliver]:
        """Iterate over them, oldest first."""
        return iter(self._messages)

    def add(self, topic: str, payload: bytes, client: int) -> robot_link.Deliver:
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
        deliver = robot_link.Deliver(topic, payload, client, next(self._sequences))
        self._messages.append(deliver)
        return deliver

    def follow(self, applied: int) -> None:
        """Let the numbers of messages go on from the last that a container took, if it is the first one."""
        if self._before is None:
            self._before = applied

    def sent(self, deliver: robot_link.Deliver) -> robot_link.Deliver:
        """Return a message as it is sent, which may be once a first container was followed."""
        if not self._before:
            return deliver
        return msgspec.structs.replace(deliver, sequence=deliver.sequence + self._before)

    def own(self, sequence: int) -> int:
        """Return the number that a message has here, of that by which it was sent; 0 stays 0."""
        return sequence - (self._before or 0) if sequence else 0

    def acknowledge(self, sequence: int) -> None:
        """Forget all up to a number by which it was sent."""
        sequence = self.own(sequence)
        while self._messages and self._messages[0].sequence <= sequence:
            self._bytes -= len(self._messages.popleft().payload)
