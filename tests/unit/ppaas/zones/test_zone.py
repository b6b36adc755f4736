"""Zones as GeoJSON: what is read comes back, and what is wrong is refused with its reason."""

import json
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidZones
from ppaas.zones.reading import geojson_of, zones_of
from ppaas.zones.zone import (
    MOST_CAPACITIES,
    MOST_MARKS,
    MOST_ON_LANES,
    MOST_POSITIONS,
    MOST_ZONES,
    NO_ZONES,
    Capacity,
    KeepOut,
    OneWay,
    SpeedZone,
    ZoneSet,
)
from tests.support.world.zones import zone_sets

SQUARE = {"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]]}
POINT = {"type": "Point", "coordinates": [3, 4]}
LINE = {"type": "LineString", "coordinates": [[0, 0], [1, 0]]}


def feature(geometry: Any = SQUARE, **properties: Any) -> dict[str, Any]:
    return {"type": "Feature", "geometry": geometry, "properties": {"name": "a", "kind": "keep_out"} | properties}


def text(*features: Any, **members: Any) -> str:
    return json.dumps({"type": "FeatureCollection", "features": features} | members)


@given(zone_sets())
def test_zones_that_are_written_and_read_are_equal(zones: ZoneSet) -> None:
    data = geojson_of(zones)
    assert zones_of(data) == zones
    assert geojson_of(zones_of(data)) == data
    assert json.loads(data)["type"] == "FeatureCollection"


@given(zone_sets())
def test_text_is_read_as_bytes_are(zones: ZoneSet) -> None:
    assert zones_of(geojson_of(zones).decode()) == zones


def test_what_editors_add_is_ignored() -> None:
    noted = feature(fid=1, id=2, title="t", description="d", stroke="#f00", fill=None, max_speed=None)
    noted["properties"] |= {"stroke-width": 2, "fill-opacity": 0.5, "marker-color": "#f00", "_leaflet": {}}
    noted["properties"] |= {"@id": "way/7", "OBJECTID": 3, "Shape_Area": 1.5, "layer": "zones", "tessellate": -1}
    high = {"type": "Polygon", "coordinates": [[[*place, 7.5] for place in SQUARE["coordinates"][0]]]}
    noted |= {"id": "f1", "bbox": [0, 0, 1, 1], "geometry": high}
    (zone,) = zones_of(text(noted, crs={"type": "name"}, name="layer", in_force=["a"])).zones
    assert zone.rule == KeepOut(name="a")
    assert zone.area.high.tolist() == [1.0, 1.0]


def test_a_collection_without_features_is_no_zones() -> None:
    assert zones_of(text()) == NO_ZONES
    assert zones_of(geojson_of(NO_ZONES)) == NO_ZONES


def test_each_kind_has_its_rule() -> None:
    features = [
        feature(name="speed", kind="speed_limit", percent=50),
        feature(name="lane", kind="one_way", geometry=LINE, width=1.5),
        feature(name="lift", kind="capacity", robots=1),
    ]
    speed, lane, lift = zones_of(text(*features)).zones
    assert speed.rule == SpeedZone(name="speed", percent=50.0)
    assert lane.rule == OneWay(name="lane", width=1.5)
    assert lane.area.low.tolist() == [-0.75, -0.75]
    assert lift.rule == Capacity(name="lift", robots=1)


def polygon(*ring: Any) -> dict[str, Any]:
    return {"type": "Polygon", "coordinates": [list(ring)]}


def line(*places: Any) -> dict[str, Any]:
    return {"type": "LineString", "coordinates": list(places)}


WRONG: dict[str, tuple[str | bytes, str]] = {
    "not JSON": ("{", "zones are not valid JSON"),
    "not text": (b"\xff\xfe\xff", "zones are not valid JSON"),
    "a lone surrogate": ('{"type": "\ud800"}', "zones are not valid JSON"),
    "an escaped surrogate": (b'{"type": "\\ud800"}', "zones are not valid JSON"),
    "a list": ("[]", "zones must be a FeatureCollection of GeoJSON: Expected `object`"),
    "a feature": (json.dumps(feature()), "zones must be a FeatureCollection of GeoJSON"),
    "no features": ('{"type": "FeatureCollection"}', "missing required field `features`"),
    "deep properties": (text(feature(_x=0)).replace("0}", "[" * 100_000 + "]" * 100_000 + "}"), "nested too deeply"),
    "no geometry": (text(feature(None)), "zone 'a' (features[0].geometry) has no geometry: draw a polygon"),
    "a point": (text(feature(POINT)), "a station, a passage or a dock is a point, and all"),
    "a station that is an area": (text(feature(kind="station")), "a station, a passage or a dock is a point"),
    "a station with times": (text(feature(POINT, kind="station", times=[{}])), "a station has no times"),
    "a station for what nobody does": (
        text(feature(POINT, kind="station", uses=["sing"])),
        "Invalid enum value 'sing'",
    ),
    "too many stations": (
        text(*(feature(POINT, name=f"s{n}", kind="station") for n in range(MOST_MARKS + 1))),
        f"a map may have {MOST_MARKS} stations, doors and docks, not {MOST_MARKS + 1}",
    ),
    "many points": (text(feature({"type": "MultiPoint", "coordinates": [[0, 0]]})), "Invalid value 'MultiPoint'"),
    "no properties": (text({"type": "Feature", "geometry": SQUARE, "properties": None}), "features[0].properties"),
    "a position of one number": (text(feature(polygon([0], [1, 0], [1, 1]))), "a position must be x, y in metres"),
    "a text in a position": (text(feature(polygon(["x", 0], [1, 0], [1, 1]))), "Expected `float`, got `str`"),
    "far away": (text(feature(polygon([0, 0], [1, 0], [1e6, 1]))), "up to 100000 in the map's frame, not [1000000.0"),
    "an infinite position": (text(feature(polygon([0, 0], [1, 0], [9e999, 1]))).replace("Infinity", "9e999"), "Number"),
    "a ring of two": (text(feature(polygon([0, 0], [1, 0], [0, 0]))), "a ring needs three different positions"),
    "an empty ring": (text(feature(polygon())), "zone 'a' has no coordinates"),
    "no rings": (text(feature({"type": "Polygon", "coordinates": []})), "zone 'a' has no coordinates"),
    "no polygons": (text(feature({"type": "MultiPolygon", "coordinates": [[]]})), "zone 'a' has no coordinates"),
    "a line of one": (text(feature(line([0, 0]), kind="one_way", width=1)), "a line needs two positions"),
    "a line that stands": (text(feature(line([0, 0], [0, 0]), kind="one_way", width=1)), "a line needs two positions"),
    "a line to keep out of": (
        text(feature(LINE)),
        "zone 'a': only a lane, a door or a one_way zone may be",
    ),
    "a lane that is an area": (text(feature(kind="lane")), "zone 'a': a lane is a line; a polygon with"),
    "a lane with times": (text(feature(LINE, kind="lane", times=[{}])), "zone 'a': a lane is always in force; draw"),
    "a wide lane": (text(feature(LINE, kind="lane", width=1)), "Object contains unknown field `width`"),
    "a line without width": (text(feature(LINE, kind="one_way")), "zone 'a': a one_way line needs its 'width'"),
    "an area without direction": (text(feature(kind="one_way")), "zone 'a': a one_way polygon needs a 'direction'"),
    "an unknown kind": (text(feature(kind="moat")), "properties of zone 'a': Invalid value 'moat'"),
    "no kind": (text(feature(kind=None)), "properties of zone 'a': Object missing required field `kind`"),
    "no name": (text(feature(), feature(name=None)), "properties of zone 1: Object missing required field `name`"),
    "an empty name": (text(feature(name="")), "properties of zone '': Expected `str` of length >= 1"),
    "a long name": (text(feature(name="x" * 65)), "Expected `str` of length <= 64"),
    "a misspelt property": (text(feature(tmies=[])), "properties of zone 'a': Object contains unknown field `tmies`"),
    "two names": (text(feature(), feature()), "two zones have the name 'a': rename one of them"),
    "no speed": (text(feature(kind="speed_limit")), "zone 'a' needs either 'max_speed' [m/s] or 'percent'"),
    "two speeds": (text(feature(kind="speed_limit", max_speed=1, percent=1)), "needs either 'max_speed'"),
    "standing": (text(feature(kind="speed_limit", max_speed=0)), "Expected `float` > 0.0"),
    "no robots": (text(feature(kind="capacity", robots=0)), "Expected `int` >= 1"),
    "half a robot": (text(feature(kind="capacity", robots=1.5)), "Expected `int`, got `float`"),
    "an unknown day": (text(feature(times=[{"days": ["sunday"]}])), "Invalid enum value 'sunday'"),
    "hour 25": (text(feature(times=[{"from": "25:00"}])), "Expected a time of day such as '08:30'"),
    "a line feed in a clock": (text(feature(times=[{"from": "08:30\n"}])), "Expected a time of day such as '08:30'"),
    "since after until": (
        text(feature(times=[{"since": "2030-01-02T00:00:00", "until": "2030-01-01T00:00:00"}])),
        "properties of zone 'a': 'until' must be after 'since'",
    ),
    "one offset": (
        text(feature(times=[{"since": "2030-01-02T00:00:00Z", "until": "2030-02-01T00:00:00"}])),
        "'since' and 'until' must both have an offset from UTC, or none",
    ),
    "no such time zone": (text(time_zone="Mars/Olympus"), "there is no time zone 'Mars/Olympus': give a name such as"),
    "a path as time zone": (text(time_zone="../UTC"), "there is no time zone"),
    "a folder as time zone": (text(time_zone="Europe"), "there is no time zone"),
    "too many zones": (
        text(*(feature(name=f"z{number}") for number in range(MOST_ZONES + 1))),
        f"a map may have {MOST_ZONES} zones, not {MOST_ZONES + 1}",
    ),
    "too many positions": (
        text(feature(polygon(*([x, 0] for x in range(MOST_POSITIONS)), [0, 1]))),
        f"the zones of a map may have {MOST_POSITIONS} positions, not {MOST_POSITIONS + 1}",
    ),
    "too much on lanes": (
        text(feature(line(*([x, 0] for x in range(MOST_ON_LANES + 1))), kind="lane")),
        f"the lanes of a map may have {MOST_ON_LANES} positions, not {MOST_ON_LANES + 1}",
    ),
    "too many capacities": (
        text(*(feature(name=f"z{n}", kind="capacity", robots=1) for n in range(MOST_CAPACITIES + 1))),
        f"a map may have {MOST_CAPACITIES} zones of the kind 'capacity'",
    ),
    "too many hours": (text(feature(times=[{}] * 51)), "Expected `array` of length <= 50"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_zones_are_refused_with_the_reason(case: str) -> None:
    data, reason = WRONG[case]
    with pytest.raises(InvalidZones) as caught:
        zones_of(data)
    assert reason in str(caught.value)
    assert len(str(caught.value)) < 400


def test_the_reason_is_short_for_long_values() -> None:
    long_place, long_name = polygon([9e9] * 100_000), "x" * 100_000
    for data in (text(feature(name=long_name)), text(feature(long_place)), text(time_zone=long_name)):
        with pytest.raises(InvalidZones) as caught:
            zones_of(data)
        assert len(str(caught.value)) < 400


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
)


@given(JSON, JSON, JSON, st.binary(max_size=40))
def test_any_json_is_read_or_refused(geometry: Any, properties: Any, value: Any, raw: bytes) -> None:
    one = {"type": "Feature", "geometry": geometry, "properties": properties}
    other = feature(name=value, times=[{"days": value, "since": value}])
    for data in (value, {"type": "FeatureCollection", "features": [one]}, json.loads(text(other)), None):
        try:
            zones_of(raw if data is None else msgspec.json.encode(data))
        except InvalidZones:
            continue
