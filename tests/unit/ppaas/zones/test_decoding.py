"""Files of zones whose JSON is none, and properties as tables of a GIS, OpenStreetMap and PostgreSQL have them."""

import json
from typing import Any

import pytest

from ppaas.errors import InvalidZones
from ppaas.zones.reading import read_zones, zones_of
from ppaas.zones.zone import KINDS, Capacity, KeepOut, Lane, SpeedZone
from tests.support.geojson import LINE, SQUARE, collection, feature

NAN = float("nan")


def test_properties_that_are_nan_are_missing_as_pandas_means_them() -> None:
    """As ``GeoDataFrame.to_json(na="keep")`` writes them."""
    data = collection(feature(max_speed=NAN, robots=float("inf")))
    assert b"NaN" in data
    zones, notes = read_zones(data)
    assert zones == zones_of(collection(feature()))
    assert notes.texts() == ["NaN and infinite numbers are not JSON, and were read as null"]


def test_heights_that_are_nan_are_left_out() -> None:
    tall = {"type": "Polygon", "coordinates": [[[*place, NAN] for place in SQUARE["coordinates"][0]]]}
    assert zones_of(collection(feature(tall))) == zones_of(collection(feature()))


def test_positions_that_are_nan_are_refused_with_the_zone_and_the_place() -> None:
    wrong = {"type": "Polygon", "coordinates": [[[3, 1], [NAN, 2], [4, 4], [3, 1]]]}
    with pytest.raises(
        InvalidZones, match=r"zone 'dock' .*coordinates\[0\]\[1\]\[0\].*; it begins at \(3, 1\)"
    ) as caught:
        zones_of(collection(feature(wrong, name="dock")))
    assert [(fault.zone, fault.place) for fault in caught.value.faults] == [("dock", (3.0, 1.0))]


@pytest.mark.parametrize("begin", ["", "\x1e"])
def test_features_one_by_one_are_named(begin: str) -> None:
    data = "".join(f"{begin}{json.dumps(feature(name=name))}\n" for name in "ab")
    with pytest.raises(InvalidZones, match="features one by one"):
        zones_of(data)


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (collection(feature(name="Süd")).decode().encode("latin-1"), "save the file in UTF-8"),
        (b"", "the file is empty"),
        (b'{"features": [NaN', "JSON is malformed"),
        (b'{"features": [NaN, "\\ud800"]}', "JSON is malformed"),
    ],
)
def test_other_texts_are_refused_with_what_is_wrong(data: bytes, text: str) -> None:
    with pytest.raises(InvalidZones, match="zones are not valid JSON") as caught:
        zones_of(data)
    assert text in str(caught.value)


@pytest.mark.parametrize("name", [1_000_001, 1_000_001.0])
def test_numbers_as_names_keep_all_digits(name: float) -> None:
    zones = zones_of(collection(feature(name=name), feature(name=1_000_002)))
    assert [zone.name for zone in zones.zones] == ["1000001", "1000002"]


@pytest.mark.parametrize(
    ("properties", "rule"),
    [
        ({"times": "", "time_zone": " "}, KeepOut(name="a")),
        ({"times": "null"}, KeepOut(name="a")),
        ({"kind": "capacity", "robots": "2.0", "max_speed": ""}, Capacity(name="a", robots=2)),
        ({"kind": "speed_limit", "max_speed": "", "percent": 50}, SpeedZone(name="a", percent=50.0)),
    ],
)
def test_cells_of_a_table_that_are_empty_have_no_value(properties: dict[str, Any], rule: Any) -> None:
    assert zones_of(collection(feature(**properties))).zones[0].rule == rule


@pytest.mark.parametrize(
    ("word", "one_way"), [("yes", True), ("T", True), ("TRUE", True), ("no", False), ("f", False), ("0", False)]
)
def test_switches_are_read_as_openstreetmap_and_postgresql_write_them(word: str, one_way: bool) -> None:
    zones, notes = read_zones(collection(feature(LINE, kind="lane", one_way=word)))
    assert zones.zones[0].rule == Lane(name="a", one_way=one_way)
    assert "read as what they were" in notes.texts()[0]


def test_columns_may_be_in_capitals_as_dbase_and_kml_have_them() -> None:
    properties = {"NAME": "a", "Kind": "speed_limit", "MAX_SPEED": 0.5, "Description": "made of KML"}
    zones, notes = read_zones(collection({"type": "Feature", "properties": properties, "geometry": SQUARE}))
    assert zones.zones[0].rule == SpeedZone(name="a", max_speed=0.5)
    assert "read as what they were" in notes.texts()[0]
    with pytest.raises(InvalidZones, match="unknown field `Kind`"):
        zones_of(collection(feature(Kind="no_stop")))
    with pytest.raises(InvalidZones, match=r"properties of zone 'b'.*unknown field `wide`"):
        zones_of(collection({"type": "Feature", "properties": {"Name": "b", "KIND": "keep_out", "wide": 1}}))


@pytest.mark.parametrize("kind", ["KEEP_OUT", "moat", None, ""])
def test_kinds_are_listed_where_it_is_none_of_them(kind: str | None) -> None:
    with pytest.raises(InvalidZones, match=f"its kind is one of {', '.join(KINDS)}"):
        zones_of(collection(feature(kind=kind)))


@pytest.mark.parametrize(
    ("hours", "text"),
    [
        ({"from": "8:00"}, "Expected a time of day such as '08:30' or '24:00' - at `$.times[0].from`"),
        ({"to": "17:00:00"}, "Expected a time of day such as '08:30' or '24:00' - at `$.times[0].to`"),
        ({"since": "2026-05-01"}, "give a moment such as '2026-05-01T08:00:00'"),
    ],
)
def test_times_that_are_none_are_refused_with_an_example(hours: dict[str, str], text: str) -> None:
    with pytest.raises(InvalidZones) as caught:
        zones_of(collection(feature(times=[hours])))
    assert text in str(caught.value)
