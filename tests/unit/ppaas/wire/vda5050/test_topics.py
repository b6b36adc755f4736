"""Topics of VDA 5050."""

import pytest

from ppaas.errors import InvalidInput
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.topics import Address, Version, parse_topic


def test_topics_have_the_interface_of_the_version() -> None:
    assert Address.of(Version.V2_0, "ppaas", "tb1").topic("order") == "uagv/v2/ppaas/tb1/order"
    assert Address.of(Version.V3_0, "ppaas", "tb1").topic("zoneSet") == "vda5050/v3/ppaas/tb1/zoneSet"
    assert Address.of(Version.V2_1, "ppaas", "tb1", "hall").topic("state") == "hall/v2/ppaas/tb1/state"


def test_a_topic_is_read_as_it_was_made() -> None:
    address = Address.of(Version.V3_0, "KIT", "0001")
    assert parse_topic(address.topic("state")) == (address, "state")


@pytest.mark.parametrize("topic", ["", "uagv/v2/a/b", "uagv/v2//b/state", "uagv/v2/a/b/state/more"])
def test_other_topics_are_refused(topic: str) -> None:
    with pytest.raises(InvalidInput, match="interface/version/manufacturer/serialNumber/topic"):
        parse_topic(topic)


@pytest.mark.parametrize("name", ["", "a/b", "+", "#", "a\0", "$SYS", "x" * 201])
def test_names_with_a_meaning_in_mqtt_are_refused(name: str) -> None:
    with pytest.raises(InvalidInput, match="serial number"):
        Address.of(Version.V2_1, "ppaas", name)


def test_connections_alone_are_retained() -> None:
    assert topics.quality_of(topics.CONNECTION) == (1, True)
    assert topics.quality_of(topics.STATE) == (0, False)


def test_zones_are_of_version_3() -> None:
    assert topics.ZONE_SET in topics.topics_to_agv(Version.V3_0)
    assert topics.topics_to_agv(Version.V2_1) == ("order", "instantActions")
