"""Header ids of what an AGV sends: repeated and late messages are told from those of an AGV that was restarted."""

from enum import Enum

from ppaas.errors import MalformedMessage
from ppaas.wire.vda5050.headers import Header, seconds_of


class Arrival(Enum):
    """Place of a message among those before."""

    NEXT = "next"
    REPEATED = "repeated"
    LATE = "late"
    RESTARTED = "restarted"


class HeaderWatch:
    """Watches the headers of one topic of one AGV."""

    def __init__(self) -> None:
        self._last: Header | None = None

    def take(self, header: Header) -> Arrival:
        """Return the place of a message by its header.

        An id that goes back is of an AGV that was restarted if its time is later; otherwise the message is late.
        """
        last = self._last
        if last is None or header.header_id > last.header_id:
            self._last = header
            return Arrival.NEXT
        if header == last:
            return Arrival.REPEATED
        if not is_later(header, last):
            return Arrival.REPEATED if header.header_id == last.header_id else Arrival.LATE
        self._last = header
        return Arrival.RESTARTED


def is_later(header: Header, other: Header) -> bool:
    """Return whether a header has a later time than another; false if one of them has none that can be read."""
    try:
        return seconds_of(header.timestamp) > seconds_of(other.timestamp)
    except MalformedMessage:
        return False
