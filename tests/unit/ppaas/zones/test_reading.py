"""Files of zones as editors, Windows and GIS write them; and files that are no zones."""

import json
from typing import Any

import pytest

from ppaas.errors import InvalidZones
from ppaas.zones.gate import checked_zones
from ppaas.zones.reading import geojson_of, read_zones, with_time_zones, zones_of
from ppaas.zones.zone import Capacity, KeepOut, Lane, OneWay, Zone, ZoneSet
from tests.support.geojson import LINE, SQUARE, collection, feature

OF_ALL = "not in Europe/Berlin, that of the collection"
WORK = [{"days": ["mon"], "from": "09:00", "to": "17:00"}]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-32"])
def test_zones_are_read_in_any_encoding_of_unicode(encoding: str) -> None:
    data = collection(feature(name="Süd")).decode().encode(encoding)
    assert [zone.name for zone in zones_of(data).zones] == ["Süd"]


def test_a_byte_order_mark_of_text_is_ignored() -> None:
    assert zones_of("\ufeff" + collection(feature()).decode()).zones


@pytest.mark.parametrize(
    ("properties", "rule"),
    [
        ({"kind": "capacity", "robots": 2.0}, Capacity(name="a", robots=2)),
        ({"kind": "capacity", "robots": "2"}, Capacity(name="a", robots=2)),
        ({"name": 12.0}, KeepOut(name="12")),
        ({"name": 7}, KeepOut(name="7")),
        ({"times": json.dumps(WORK)}, zones_of(collection(feature(times=WORK))).zones[0].rule),
        ({"kind": "one_way", "direction": "0.5", "strict": 1}, OneWay(name="a", direction=0.5, strict=True)),
        ({"kind": "one_way", "direction": 1, "strict": 0.0}, OneWay(name="a", direction=1.0, strict=False)),
    ],
)
def test_what_tables_make_of_values_is_read_as_what_it_was(properties: dict[str, Any], rule: Any) -> None:
    read, notes = read_zones(collection(feature(**properties)))
    assert read.zones[0].rule == rule
    if "times" in properties:
        assert any("no time zone" in text for text in notes.texts())
    assert any("read as what they were" in text for text in notes.texts())


def test_properties_as_they_were_need_no_word() -> None:
    lane = feature(LINE, kind="lane", one_way=True)
    read, notes = read_zones(collection(lane))
    assert (read.zones[0].rule, notes.texts()) == (Lane(name="a", one_way=True), [])


@pytest.mark.parametrize("times", ["{", '"mon"'])
def test_hours_as_text_that_are_none_are_refused(times: str) -> None:
    with pytest.raises(InvalidZones, match="properties of zone 'a'"):
        zones_of(collection(feature(times=times)))


def test_all_features_that_are_no_zones_are_named() -> None:
    point = {"type": "Point", "coordinates": [0, 0]}
    with pytest.raises(InvalidZones) as caught:
        zones_of(
            collection(feature(name="good"), feature(None, name="b"), feature(point, name="c"), feature(kind="moat"))
        )
    assert [fault.zone for fault in caught.value.faults] == ["b", "c", "a"]
    assert "zone 'b' (features[1].geometry) has no geometry" in str(caught.value)
    assert "zone 'c': a station, a passage or a dock is a point, and all other" in str(caught.value)


def test_many_faults_are_counted_in_a_short_text() -> None:
    with pytest.raises(InvalidZones) as caught:
        zones_of(collection(*(feature(None, name=f"zone number {number}") for number in range(100))))
    assert len(str(caught.value)) < 500
    assert str(caught.value).endswith("more")
    assert len(caught.value.faults) == 20


# Time zones --------------------------------------------------------------------------------------------------------


def through_gdal(data: bytes) -> bytes:
    """Return GeoJSON as drivers of GDAL write it again: without members of the collection that they do not know."""
    tree = json.loads(data)
    return json.dumps({key: tree[key] for key in ("type", "features")} | {"name": "b"}).encode()


def test_time_zones_survive_what_drops_members_of_the_collection() -> None:
    given = zones_of(collection(feature(times=WORK), feature(name="b"), time_zone="Europe/Berlin"))
    back, notes = read_zones(through_gdal(geojson_of(with_time_zones(given))))
    assert back == given
    assert back.time_zone == "Europe/Berlin"
    assert notes.texts() == []


def test_a_zone_may_have_a_time_zone_of_its_own() -> None:
    tokyo = feature(name="b", times=WORK, time_zone="Asia/Tokyo")
    zones, notes = read_zones(collection(feature(times=WORK), tokyo, time_zone="Europe/Berlin"))
    assert [zones.time_zone_of(zone) for zone in zones.zones] == ["Europe/Berlin", "Asia/Tokyo"]
    assert notes.texts() == [f"zone 'b': its times are in its own time zone, {OF_ALL}"]
    monday_9_in_tokyo = 1767571200.0  # 2026-01-05T00:00Z
    assert names(zones.in_force(monday_9_in_tokyo)) == ["b"]
    assert names(zones.in_force(monday_9_in_tokyo + 8 * 3600.0)) == ["a"], "09:00 in Berlin"
    assert zones.next_change(monday_9_in_tokyo - 1.0) == monday_9_in_tokyo
    assert zones_of(geojson_of(zones)) == zones


def names(zones: list[Zone]) -> list[str]:
    return [zone.name for zone in zones]


def test_times_without_a_time_zone_are_in_utc_with_a_word() -> None:
    zones, notes = read_zones(collection(feature(times=WORK)))
    assert zones.time_zone == "UTC"
    assert notes.texts()[0].startswith("zone 'a': its times have no time zone, so they are in UTC: give 'time_zone'")
    assert read_zones(collection(feature(times=WORK), time_zone="UTC")).notes.texts() == []
    assert read_zones(collection(feature())).notes.texts() == []


def test_zones_without_times_need_no_time_zone() -> None:
    zones = zones_of(collection(feature(time_zone="Asia/Tokyo"), time_zone="Europe/Berlin"))
    assert zones == ZoneSet([Zone(zones.zones[0].geometry, KeepOut(name="a"))], "Europe/Berlin")


@pytest.mark.parametrize("given", [{"time_zone": 1}, {"time_zone": ["UTC"]}])
def test_a_time_zone_is_a_name(given: dict[str, Any]) -> None:
    with pytest.raises(InvalidZones, match="time_zone must be a name"):
        zones_of(collection(feature(), **given))


def test_an_unknown_time_zone_of_a_zone_is_refused() -> None:
    with pytest.raises(InvalidZones, match="zone 'a': there is no time zone 'Mars'"):
        zones_of(collection(feature(times=WORK, time_zone="Mars")))
    with pytest.raises(InvalidZones, match="there is no time zone 'asia/tokyo': give a name such as 'Asia/Tokyo'"):
        zones_of(collection(feature(times=WORK, time_zone="asia/tokyo")))


@pytest.mark.parametrize("given", ["", " ", None])
def test_an_empty_time_zone_is_none_and_lets_times_be_in_utc_with_a_word(given: str | None) -> None:
    zones, notes = read_zones(collection(feature(times=WORK), time_zone=given))
    assert zones.time_zone == "UTC"
    assert "so they are in UTC" in notes.texts()[0]


@pytest.mark.parametrize("name", ["localtime", "posixrules", "Factory", "right/Europe/Berlin"])
def test_time_zones_that_differ_from_computer_to_computer_are_not_published_but_stay(name: str) -> None:
    data = collection(feature(times=WORK), time_zone=name)
    try:
        stored = zones_of(data)
    except InvalidZones:
        return  # this computer has none of that name
    assert stored.time_zone == name
    with pytest.raises(InvalidZones, match=r"zone 'a': its time zone .* is no place"):
        checked_zones(data)
    assert checked_zones(collection(feature(), time_zone=name)).warnings == [], "it has no times"


# Faults and places ---------------------------------------------------------------------------------------------------


def test_zones_of_one_name_are_both_named_by_their_places() -> None:
    other = {"type": "LineString", "coordinates": [[3, 4], [5, 4]]}
    with pytest.raises(InvalidZones, match=r"two zones have the name 'a': .* at \(0, 0\) and \(3, 4\)") as caught:
        zones_of(collection(feature(), feature(other, kind="lane")))
    assert [(fault.zone, fault.place) for fault in caught.value.faults] == [("a", (3.0, 4.0))]


@pytest.mark.parametrize(
    ("geometry", "place"),
    [
        ({"type": "Point", "coordinates": [3, 4]}, (3.0, 4.0)),
        ({"type": "GeometryCollection", "geometries": [SQUARE]}, (0.0, 0.0)),
        ({"type": "Polygon", "coordinates": [[[7, 8], [9, 8], [7, 8]]]}, (7.0, 8.0)),
        ({"type": "Polygon", "coordinates": [[[7, 8], [9e9, 8], [7, 9], [7, 8]]]}, (9e9, 8.0)),
        ({"type": "LineString", "coordinates": [[7, 8]]}, (7.0, 8.0)),
        ({"type": "Polygon", "coordinates": [[[7, 8], ["9", 8], [7, 9], [7, 8]]]}, (7.0, 8.0)),
        ({"type": "MultiPolygon", "coordinates": []}, None),
    ],
)
def test_a_geometry_that_is_none_is_refused_with_the_zone_and_its_place(geometry: Any, place: Any) -> None:
    with pytest.raises(InvalidZones, match="zone 'dock'") as caught:
        zones_of(collection(feature(name="good"), feature(geometry, name="dock")))
    assert [(fault.zone, fault.place) for fault in caught.value.faults] == [("dock", place)]


def test_a_wrong_property_is_refused_with_the_place_of_its_zone() -> None:
    with pytest.raises(InvalidZones) as caught:
        zones_of(collection(feature({"type": "Point", "coordinates": [3, 4]}, kind="moat")))
    assert caught.value.faults[0].place == (3.0, 4.0)


# Files that are no zones ---------------------------------------------------------------------------------------------


def node(number: int) -> dict[str, Any]:
    geometry = {"type": "Point", "coordinates": [number, 0]}
    return {"type": "Feature", "properties": {"id": number, "frame": "map"}, "geometry": geometry}


def edge(one: int, other: int) -> dict[str, Any]:
    geometry = {"type": "MultiLineString", "coordinates": [[[one, 0], [other, 0]]]}
    return {"type": "Feature", "properties": {"id": 9, "startid": one, "endid": other}, "geometry": geometry}


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (collection(node(0), node(1), edge(0, 1)), "a route graph of Nav2 with 2 nodes and 1 edges"),
        (json.dumps({"metaInformation": {}, "layouts": []}), "a layout of LIF (VDMA)"),
        (json.dumps({"building_name": "x", "levels": {}}), "navigation graph of Open-RMF"),
        ("building_name: office\nlevels:\n  L1:\n    lanes: []\n", "YAML of Open-RMF"),
    ],
    ids=["Nav2", "LIF", "Open-RMF", "Open-RMF as YAML"],
)
def test_a_graph_of_routes_is_named_with_what_makes_lanes_of_it(data: str | bytes, what: str) -> None:
    with pytest.raises(InvalidZones) as caught:
        zones_of(data)
    assert what in str(caught.value)
    assert "ppaas map import-graph MAP FILE" in str(caught.value)


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (json.dumps({"zoneSet": {"zones": []}}), "give it with --vda5050"),
        (json.dumps({"type": "Topology", "arcs": [], "objects": {}}), "this is TopoJSON"),
        (json.dumps({"geometryType": "esriGeometryPolygon", "features": []}), "must be a FeatureCollection"),
        ("<kml></kml>", "this is XML"),
        (json.dumps(feature()), "not one Feature: put it into 'features'"),
        (json.dumps(SQUARE), "not one Polygon: put it into 'features'"),
    ],
)
def test_other_files_are_named(data: str, what: str) -> None:
    with pytest.raises(InvalidZones) as caught:
        zones_of(data)
    assert what in str(caught.value)
