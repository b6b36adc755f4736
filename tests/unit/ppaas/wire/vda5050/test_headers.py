"""Headers of VDA 5050."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import MalformedMessage
from ppaas.wire.vda5050.headers import HeaderCounter, seconds_of, timestamp
from ppaas.wire.vda5050.topics import Address, Version


def test_ids_count_by_topic() -> None:
    counter = HeaderCounter(Version.V2_1, Address.of(Version.V2_1, "ppaas", "tb1"))
    made = [counter.next(topic, 0.0) for topic in ("state", "state", "connection", "state")]
    assert [header.header_id for header in made] == [0, 1, 0, 2]
    assert (made[0].version, made[0].manufacturer, made[0].serial_number) == ("2.1.0", "ppaas", "tb1")


def test_times_are_in_utc_to_the_millisecond() -> None:
    assert timestamp(0.1234) == "1970-01-01T00:00:00.123Z"


@given(st.floats(0, 4e9))
def test_times_are_read_as_they_were_written(seconds: float) -> None:
    assert seconds_of(timestamp(seconds)) == pytest.approx(seconds, abs=0.001)


def test_offsets_of_times_are_read() -> None:
    assert seconds_of("1970-01-01T01:00:00+01:00") == 0.0
    assert seconds_of("1970-01-01T00:00:01.5") == 1.5


@pytest.mark.parametrize("text", ["", "soon", "2026-13-01T00:00:00Z"])
def test_other_times_are_refused(text: str) -> None:
    with pytest.raises(MalformedMessage, match="ISO 8601"):
        seconds_of(text)
