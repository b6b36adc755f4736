"""Zones in force: the same object until others are."""

from datetime import UTC, datetime

from ppaas.zones.schedule import Hours
from ppaas.zones.zone import NO_ZONES, KeepOut, NoStop, ZoneSet, ZonesInForce
from tests.support.zones import rectangle

BOX = (0.0, 0.0, 1.0, 1.0)


def test_zones_are_the_same_object_until_others_come_into_force() -> None:
    later = KeepOut(name="later", times=[Hours(since=datetime.fromtimestamp(1_000_000.0, UTC))])
    zones = ZonesInForce(ZoneSet([rectangle(NoStop(name="always"), *BOX), rectangle(later, *BOX)]))
    before = zones.at(900_000.0)
    assert [zone.name for zone in before] == ["always"]
    assert zones.at(999_999.0) is before, "also after midnights, which change nothing"
    after = zones.at(1_000_000.0)
    assert [zone.name for zone in after] == ["always", "later"]
    assert zones.at(1_000_001.0) is after


def test_a_map_without_zones_has_none_in_force() -> None:
    assert list(ZonesInForce(NO_ZONES).at(0.0)) == []
