"""Headers of messages: numbers that count by topic, and times in ISO 8601."""

from collections import Counter
from datetime import UTC, datetime

from ppaas.errors import MalformedMessage
from ppaas.wire.vda5050.fields import Fields
from ppaas.wire.vda5050.topics import AgvAddress, Version

WRAP = 1 << 32
"""Number of header ids: they are uint32."""


class MessageHeader(Fields):
    """Header that all messages begin with."""

    header_id: int
    timestamp: str
    version: str
    manufacturer: str
    serial_number: str


class HeaderCounter:
    """Makes the headers of one sender for one AGV. Ids count by topic from 0.

    Parameters
    ----------
    version : Version
    address : AgvAddress
    """

    def __init__(self, version: Version, address: AgvAddress) -> None:
        self._version, self._address = version, address
        self._sent: Counter[str] = Counter()

    def next(self, topic: str, now: float) -> MessageHeader:
        """Return the header of the next message of a topic.

        Parameters
        ----------
        topic : str
            Last level of the topic.
        now : float
            Time [s since the epoch].
        """
        number = self._sent[topic] % WRAP
        self._sent[topic] += 1
        return MessageHeader(
            header_id=number,
            timestamp=timestamp(now),
            version=self._version.value,
            manufacturer=self._address.manufacturer,
            serial_number=self._address.serial,
        )


def timestamp(seconds: float) -> str:
    """Return a time [s since the epoch] in ISO 8601, UTC, to the millisecond."""
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def seconds_of(text: str) -> float:
    """Return a time in ISO 8601 as seconds since the epoch; without an offset it is in UTC.

    Raises
    ------
    MalformedMessage
        The text is not a time in ISO 8601.
    """
    try:
        time = datetime.fromisoformat(text)
        return (time if time.tzinfo else time.replace(tzinfo=UTC)).timestamp()
    except (ValueError, OverflowError) as error:
        raise MalformedMessage(f"{text[:40]!r} is not a time in ISO 8601, as 2026-01-31T11:40:03.123Z") from error
