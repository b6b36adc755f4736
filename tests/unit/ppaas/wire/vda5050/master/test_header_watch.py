"""Headers that are repeated, late, or of an AGV that was restarted."""

from ppaas.wire.vda5050.headers import MessageHeader, timestamp
from ppaas.wire.vda5050.master.header_watch import RUN, HeaderOrder, HeaderWatch


def header(number: int, at: float) -> MessageHeader:
    return MessageHeader(
        header_id=number, timestamp=timestamp(1e9 + at), version="2.1.0", manufacturer="acme", serial_number="7"
    )


def test_each_message_has_its_place():
    watch = HeaderWatch()
    assert watch.take(header(5, 0.0)) is HeaderOrder.NEXT
    assert watch.take(header(5, 0.0)) is HeaderOrder.REPEATED
    assert watch.take(header(9, 1.0)) is HeaderOrder.NEXT
    assert watch.take(header(8, 0.5)) is HeaderOrder.LATE
    assert watch.take(header(0, 2.0)) is HeaderOrder.RESTARTED
    assert watch.take(header(1, 2.5)) is HeaderOrder.NEXT


def test_a_time_that_cannot_be_read_is_not_later():
    watch = HeaderWatch()
    watch.take(header(5, 0.0))
    bad = header(4, 9.0)
    bad.timestamp = "yesterday"
    assert watch.take(bad) is HeaderOrder.LATE


def test_ids_that_count_up_from_the_beginning_are_of_an_agv_that_was_restarted_whatever_its_clock_says():
    watch = HeaderWatch()
    watch.take(header(5000, 0.0))
    arrivals = [watch.take(header(number, -3600.0)) for number in range(RUN)]
    assert arrivals == [HeaderOrder.LATE] * (RUN - 1) + [HeaderOrder.RESTARTED]
    assert watch.take(header(RUN, -3599.0)) is HeaderOrder.NEXT


def test_late_messages_between_others_are_never_a_restart():
    watch = HeaderWatch()
    for number in range(5000, 5020):
        assert watch.take(header(number, 0.0)) is HeaderOrder.NEXT
        assert watch.take(header(number - 5000, -9.0)) is HeaderOrder.LATE


def test_a_message_that_others_have_overtaken_leaves_them_known():
    watch = HeaderWatch()
    watch.take(header(100, 0.0))
    watch.take(header(97, -1.0))
    assert not watch.is_behind
    watch.take(header(98, -1.0))
    assert watch.is_behind, "the second in a row was not just overtaken"
    watch.take(header(101, 1.0))
    assert not watch.is_behind
    watch.take(header(0, -1.0))
    assert watch.is_behind, "nothing is overtaken by a hundred messages"
