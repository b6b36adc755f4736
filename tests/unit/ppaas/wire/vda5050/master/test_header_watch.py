"""Headers that are repeated, late, or of an AGV that was restarted."""

from ppaas.wire.vda5050.headers import Header, timestamp
from ppaas.wire.vda5050.master.header_watch import Arrival, HeaderWatch


def header(number: int, at: float) -> Header:
    return Header(
        header_id=number, timestamp=timestamp(1e9 + at), version="2.1.0", manufacturer="acme", serial_number="7"
    )


def test_each_message_has_its_place():
    watch = HeaderWatch()
    assert watch.take(header(5, 0.0)) is Arrival.NEXT
    assert watch.take(header(5, 0.0)) is Arrival.REPEATED
    assert watch.take(header(9, 1.0)) is Arrival.NEXT
    assert watch.take(header(8, 0.5)) is Arrival.LATE
    assert watch.take(header(0, 2.0)) is Arrival.RESTARTED
    assert watch.take(header(1, 2.5)) is Arrival.NEXT


def test_a_time_that_cannot_be_read_is_not_later():
    watch = HeaderWatch()
    watch.take(header(5, 0.0))
    bad = header(4, 9.0)
    bad.timestamp = "yesterday"
    assert watch.take(bad) is Arrival.LATE
