"""Places where robots charge and park are docks and stations of the map."""

from ppaas.energy.sites import NO_SITES, links_of, sites_of
from ppaas.zones.reading import zones_of
from ppaas.zones.zone import ZoneSet
from tests.support.geojson import SQUARE, collection, feature


def test_docks_that_charge_and_stations_by_their_uses_are_found() -> None:
    point = {"type": "Point", "coordinates": [1.0, 2.0]}
    zones = zones_of(
        collection(
            feature(point, name="a", kind="dock", yaw=0.5),
            feature(point, name="b", kind="dock", yaw=0.5, charges=False),
            feature(point, name="c", kind="station", uses=["charge", "park"]),
            feature(point, name="d", kind="station", uses=["park"], yaw=1.0),
            feature(point, name="e", kind="station"),
        )
    )
    sites = sites_of(zones)
    assert sites.chargers == {"a": (1.0, 2.0, 0.5), "c": (1.0, 2.0, 0.0)}
    assert sites.parking == {"d": (1.0, 2.0, 1.0)}
    assert sites_of(ZoneSet()) == NO_SITES


def test_floors_are_left_by_the_lifts_and_ways_among_their_zones() -> None:
    point = {"type": "Point", "coordinates": [1.0, 2.0]}
    zones = zones_of(
        collection(
            feature(SQUARE, name="car", kind="lift", lift="north"),
            feature(SQUARE, name="south", kind="lift"),
            feature(point, name="foot", kind="passage", way="ramp", yaw=0.5),
            feature(point, name="a", kind="dock", yaw=0.5),
        )
    )
    assert links_of(zones) == {"north", "south", "ramp"}
    assert links_of(ZoneSet()) == frozenset()
