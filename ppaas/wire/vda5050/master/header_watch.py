"""Header ids of what an AGV sends: repeated and late messages are distinguished from messages of a restarted AGV."""

from enum import Enum

from ppaas.errors import MalformedMessage
from ppaas.wire.vda5050.headers import MessageHeader, seconds_of

RUN = 5
"""Number of late messages in order, with none in between that counts, that only an AGV that was restarted sends."""

OVERTAKEN = 10
"""Number of ids up to which a single late message may have been overtaken by others on its way."""


class HeaderOrder(Enum):
    """Place of a message among those before."""

    NEXT = "next"
    REPEATED = "repeated"
    LATE = "late"
    RESTARTED = "restarted"


class HeaderWatch:
    """Watches the headers of one topic of one AGV, from the beginning of its connection on."""

    def __init__(self) -> None:
        self._last: MessageHeader | None = None
        self._late: MessageHeader | None = None
        self._run = 0

    def take(self, header: MessageHeader) -> HeaderOrder:
        """Return the place of a message by its header.

        An id that goes back is of an AGV that was restarted if its time is later, or if ids count up from there: the
        clock of an AGV may be behind after a restart, and the message that its connection has begun may be lost.
        """
        last = self._last
        if last is None or header.header_id > last.header_id:
            return self._go_on(header, HeaderOrder.NEXT)
        if header == last:
            return HeaderOrder.REPEATED
        if is_later(header, last):
            return self._go_on(header, HeaderOrder.RESTARTED)
        if header.header_id == last.header_id:
            return HeaderOrder.REPEATED
        before, self._late = self._late, header
        self._run = self._run + 1 if before is not None and header.header_id > before.header_id else 1
        return self._go_on(header, HeaderOrder.RESTARTED) if self._run >= RUN else HeaderOrder.LATE

    @property
    def is_behind(self) -> bool:
        """Whether the last message was late, and was not just overtaken by others: what they said is known no more."""
        if self._late is None or self._last is None:
            return False
        return self._run > 1 or self._last.header_id - self._late.header_id > OVERTAKEN

    def _go_on(self, header: MessageHeader, arrival: HeaderOrder) -> HeaderOrder:
        self._last, self._late, self._run = header, None, 0
        return arrival


def is_later(header: MessageHeader, other: MessageHeader) -> bool:
    """Return whether a header has a later time than another; false if one of them has none that can be read."""
    try:
        return seconds_of(header.timestamp) > seconds_of(other.timestamp)
    except MalformedMessage:
        return False
