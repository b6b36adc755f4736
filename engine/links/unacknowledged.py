"""Unacknowledged messages: stored from sending until a checkpoint of the clone contains them."""

import itertools
from collections import deque
from collections.abc import Iterator

import msgspec

from engine.protocols import robot_link
from ppaas.errors import QuotaExceeded

MAX_UNACKNOWLEDGED = 1000
MAX_UNACKNOWLEDGED_BYTES = 64 << 20
"""Largest number and total size [bytes] of the unacknowledged messages of one place."""


class Unacknowledged:
    """Messages that one place has sent, and sends again to the next container, in order.

    An earlier cloud process may have served the first container of a place. Sequence numbers on the link therefore
    continue from the last one that this container applied; here, messages are numbered from 1.
    """

    def __init__(self) -> None:
        self._sequences = itertools.count(1)
        self._before: int | None = None
        self._messages: deque[robot_link.Deliver] = deque()
        self._bytes = 0

    def __iter__(self) -> Iterator[robot_link.Deliver]:
        """Iterate over the messages, oldest first, with their numbers here."""
        return iter(self._messages)

    def add(self, topic: str, payload: bytes, client: int) -> robot_link.Deliver:
        """Store a message with the next sequence number, and return it.

        Raises
        ------
        QuotaExceeded
            Too many messages are unacknowledged: the client must slow down.
        """
        size = self._bytes + len(payload)
        if len(self._messages) >= MAX_UNACKNOWLEDGED or size > MAX_UNACKNOWLEDGED_BYTES:
            raise QuotaExceeded(f"{len(self._messages)} messages are not acknowledged yet; wait before sending more")
        self._bytes = size
        deliver = robot_link.Deliver(topic, payload, client, next(self._sequences))
        self._messages.append(deliver)
        return deliver

    def follow(self, applied: int) -> None:
        """Continue the numbers on the link from the last that the first container applied; later calls do nothing."""
        if self._before is None:
            self._before = applied

    def sent(self, deliver: robot_link.Deliver) -> robot_link.Deliver:
        """Return a message with its number on the link."""
        if not self._before:
            return deliver
        return msgspec.structs.replace(deliver, sequence=deliver.sequence + self._before)

    def own(self, sequence: int) -> int:
        """Convert a number on the link to the number here; 0 stays 0."""
        return sequence - (self._before or 0) if sequence else 0

    def acknowledge(self, sequence: int) -> None:
        """Forget all messages up to a number on the link."""
        sequence = self.own(sequence)
        while self._messages and self._messages[0].sequence <= sequence:
            self._bytes -= len(self._messages.popleft().payload)
