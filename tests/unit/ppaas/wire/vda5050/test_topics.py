"""Topics of VDA 5050."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput, MalformedMessage, NotFound
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.headers import HeaderCounter, seconds_of, timestamp
from ppaas.wire.vda5050.topics import AgvAddress, Version, parse_topic, understand, version_of


def test_topics_have_the_interface_of_the_version() -> None:
    assert AgvAddress.of(Version.V2_0, "ppaas", "tb1").topic("order") == "uagv/v2/ppaas/tb1/order"
    assert AgvAddress.of(Version.V3_0, "ppaas", "tb1").topic("zoneSet") == "vda5050/v3/ppaas/tb1/zoneSet"
    assert AgvAddress.of(Version.V2_1, "ppaas", "tb1", "hall").topic("state") == "hall/v2/ppaas/tb1/state"


def test_a_topic_is_read_as_it_was_made() -> None:
    address = AgvAddress.of(Version.V3_0, "KIT", "0001")
    assert parse_topic(address.topic("state")) == (address, "state")


@pytest.mark.parametrize("topic", ["", "uagv/v2/a/b", "uagv/v2//b/state", "uagv/v2/a/b/state/more"])
def test_other_topics_are_refused(topic: str) -> None:
    with pytest.raises(InvalidInput, match="interface/version/manufacturer/serialNumber/topic"):
        parse_topic(topic)


@pytest.mark.parametrize("name", ["", "a/b", "+", "#", "a\0", "$SYS", "x" * 201])
def test_names_with_a_meaning_in_mqtt_are_refused(name: str) -> None:
    with pytest.raises(InvalidInput, match="serial number"):
        AgvAddress.of(Version.V2_1, "ppaas", name)


def test_connections_alone_are_retained() -> None:
    assert topics.quality_of(topics.CONNECTION) == (1, True)
    assert topics.quality_of(topics.STATE) == (0, False)


def test_zones_are_of_version_3() -> None:
    assert topics.ZONE_SET in topics.topics_to_agv(Version.V3_0)
    assert topics.topics_to_agv(Version.V2_1) == ("order", "instantActions")


def test_ids_count_by_topic() -> None:
    counter = HeaderCounter(Version.V2_1, AgvAddress.of(Version.V2_1, "ppaas", "tb1"))
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


@pytest.mark.parametrize(
    ("text", "version"),
    [
        ("2.0.0", Version.V2_0),
        ("2.0", Version.V2_0),
        ("2.1.0", Version.V2_1),
        ("2.7.1", Version.V2_1),
        ("v2", Version.V2_1),
        ("2", Version.V2_1),
        ("3.0.0-rc1", Version.V3_0),
        ("v3", Version.V3_0),
    ],
)
def test_the_nearest_version_is_spoken(text: str, version: Version) -> None:
    assert version_of(text) is version


@pytest.mark.parametrize("text", ["1.1.0", "4.0.0", "", "two", "2.", "99999.0"])
def test_unknown_versions_are_refused(text: str) -> None:
    with pytest.raises(NotFound, match=r"2\.0\.0, 2\.1\.0, 3\.0\.0"):
        version_of(text)


def test_minor_versions_understand_each_other() -> None:
    assert understand(Version.V2_0, "2.1.0")
    assert not understand(Version.V2_1, "3.0.0")
    assert not understand(Version.V2_1, "nothing")
