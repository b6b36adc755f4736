"""Zones of a map as sets of zones of VDA 5050 3.0, and back."""

import json
import math
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.codec import decode
from ppaas.wire.vda5050.fields import Point
from ppaas.wire.vda5050.map_zones import expressed_zones, vda5050_of, zones_of_vda5050
from ppaas.wire.vda5050.topics import Version
from ppaas.wire.vda5050.zones import Zone, Zones
from ppaas.zones.reading import zones_of
from ppaas.zones.zone import OneWay, ZoneSet
from tests.support.vda5050.schemas import problems

NOW = 1_790_000_000.0  # a Monday, 13:33 UTC
SQUARE = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 0.0]]
VERTICES = [Point(x=0.0, y=0.0), Point(x=2.0, y=0.0), Point(x=2.0, y=1.0)]

coordinates = st.floats(-1000, 1000)
polygons = st.lists(st.builds(lambda x, y: Point(x=x, y=y), coordinates, coordinates), min_size=3, max_size=8).filter(
    lambda points: len({(point.x, point.y) for point in points}) == len(points)
)
speeds, angles = st.floats(0.01, 100.0), st.floats(-10.0, 10.0)
rules = st.one_of(
    st.just({"zone_type": "BLOCKED"}),
    st.builds(lambda speed: {"zone_type": "SPEED_LIMIT", "maximum_speed": speed}, speeds),
    st.builds(
        lambda angle, kind: {"zone_type": "DIRECTED", "direction": angle, "directed_limitation": kind},
        angles,
        st.sampled_from(["RESTRICTED", "STRICT"]),
    ),
    st.just(
        {
            "zone_type": "RELEASE",
            "release_loss_behavior": "STOP",
            "zone_descriptor": "at most 1 robot at a time",
        }
    ),
)
names = st.text(st.characters(codec="utf-8"), min_size=1, max_size=64)
zone_lists = st.lists(st.tuples(names, polygons, rules), max_size=6, unique_by=lambda one: one[0]).map(
    lambda found: [Zone(zone_id=name, vertices=vertices, **rule) for name, vertices, rule in found]
)


def features(*found: tuple[dict[str, Any], dict[str, Any]], **more: Any) -> ZoneSet:
    made = [{"type": "Feature", "geometry": geometry, "properties": rule} for geometry, rule in found]
    return zones_of(json.dumps({"type": "FeatureCollection", "features": made, **more}))


def one(rule: dict[str, Any], kind: str = "Polygon", coordinates: Any = None) -> ZoneSet:
    return features(({"type": kind, "coordinates": coordinates or [SQUARE]}, {"name": "door", **rule}))


def sent(zones: ZoneSet, **options: float) -> list[dict[str, Any]]:
    payload = vda5050_of(zones, "hall", "set-1", NOW, **options)
    assert problems(Version.V3_0, topics.ZONE_SET, payload) == []
    assert zones_of_vda5050(payload).zones is not None
    found: list[dict[str, Any]] = json.loads(payload)["zoneSet"]["zones"]
    return found


@given(zone_lists)
def test_zones_of_vda5050_are_the_same_after_they_were_zones_of_a_map(zones: list[Zone]) -> None:
    whole = Zones(map_id="hall", zone_set_id="set-1", zones=zones)
    payload = vda5050_of(zones_of_vda5050(msgspec.json.encode(whole)), "hall", "set-1", NOW)
    assert problems(Version.V3_0, topics.ZONE_SET, payload) == []
    assert decode(topics.ZONE_SET, payload, Version.V3_0)[1].zone_set == whole


@given(zone_lists)
def test_zones_of_a_map_are_the_same_after_they_were_zones_of_vda5050(zones: list[Zone]) -> None:
    own = zones_of_vda5050(msgspec.json.encode(Zones(map_id="hall", zone_set_id="set-1", zones=zones)))
    assert zones_of_vda5050(vda5050_of(own, "hall", "set-2", NOW)) == own


def test_a_message_names_the_map_the_set_and_no_agv() -> None:
    message = json.loads(vda5050_of(one({"kind": "keep_out"}), "hall", "set-1", NOW))
    assert message["zoneSet"]["mapId"] == "hall" and message["zoneSet"]["zoneSetId"] == "set-1"
    assert (message["manufacturer"], message["serialNumber"], message["version"]) == ("", "", "3.0.0")
    assert message["timestamp"] == "2026-09-21T14:13:20.000Z"


def test_kinds_have_their_types() -> None:
    (blocked,) = sent(one({"kind": "keep_out"}))
    assert (blocked["zoneId"], blocked["zoneType"], len(blocked["vertices"])) == ("door", "BLOCKED", 3)
    (slow,) = sent(one({"kind": "speed_limit", "max_speed": 0.3}))
    assert (slow["zoneType"], slow["maximumSpeed"]) == ("SPEED_LIMIT", 0.3)
    (lane,) = sent(one({"kind": "one_way", "direction": 1.5}))
    assert (lane["zoneType"], lane["direction"], lane["directedLimitation"]) == ("DIRECTED", 1.5, "RESTRICTED")
    (lane,) = sent(one({"kind": "one_way", "direction": 1.5, "strict": True}))
    assert lane["directedLimitation"] == "STRICT"
    (few,) = sent(one({"kind": "capacity", "robots": 3}))
    assert (few["zoneType"], few["releaseLossBehavior"]) == ("RELEASE", "STOP")
    assert few["zoneDescriptor"] == "at most 3 robots at a time"


def test_a_percentage_is_one_of_the_top_speed() -> None:
    percentage = one({"kind": "speed_limit", "percent": 50})
    (slow,) = sent(percentage, top_speed=1.6)
    assert slow["maximumSpeed"] == pytest.approx(0.8)
    with pytest.raises(InvalidInput, match=r"zone 'door' .* percentage.* top speed"):
        vda5050_of(percentage, "hall", "set-1", NOW)


def test_lanes_along_lines_are_rectangles_with_the_direction_of_each_segment() -> None:
    lane = {"kind": "one_way", "width": 2.0}
    first, second = sent(one(lane, "LineString", [[0, 0], [3, 0], [3, 5]]))
    assert (first["zoneId"], second["zoneId"]) == ("door", "door-2")
    assert first["vertices"] == [{"x": 0, "y": -1}, {"x": 3, "y": -1}, {"x": 3, "y": 1}, {"x": 0, "y": 1}]
    assert (first["direction"], second["direction"]) == (0.0, pytest.approx(math.pi / 2))
    corners = {(round(point["x"], 9), round(point["y"], 9)) for point in second["vertices"]}
    assert corners == {(2, 0), (4, 0), (4, 5), (2, 5)}


def test_parts_of_a_zone_have_ids_that_no_other_zone_has() -> None:
    several = {"type": "MultiPolygon", "coordinates": [[SQUARE], [SQUARE], [SQUARE]]}
    other = {"type": "Polygon", "coordinates": [SQUARE]}
    both = features((several, {"name": "a", "kind": "keep_out"}), (other, {"name": "a-2", "kind": "keep_out"}))
    assert [zone["zoneId"] for zone in sent(both)] == ["a", "a-3", "a-4", "a-2"]


def test_zones_that_are_not_in_force_are_left_out() -> None:
    monday, sunday = ({"kind": "keep_out", "times": [{"days": [day]}]} for day in ("mon", "sun"))
    assert len(sent(one(monday))) == 1
    assert sent(one(sunday)) == []


@pytest.mark.parametrize(
    ("zones", "text"),
    [
        (one({"kind": "no_stop"}), "zone 'door' is of the kind no_stop"),
        (one({"kind": "lane"}, "LineString", [[0, 0], [1, 0]]), "zone 'door' is of the kind lane"),
        (one({"kind": "keep_out"}, coordinates=[SQUARE, SQUARE]), "zone 'door' has a hole"),
        (one({"kind": "capacity", "robots": 2}, "MultiPolygon", [[SQUARE], [SQUARE]]), "several polygons"),
    ],
)
def test_zones_that_cannot_be_expressed_are_named(zones: ZoneSet, text: str) -> None:
    with pytest.raises(InvalidInput, match=text):
        vda5050_of(zones, "hall", "set-1", NOW)
    found, told = expressed_zones(zones.zones)
    assert found == [] and text in told[0]


@pytest.mark.parametrize(
    "kind", ["LINE_GUIDED", "COORDINATED_REPLANNING", "ACTION", "PRIORITY", "PENALTY", "BIDIRECTED"]
)
def test_types_without_a_zone_of_a_map_are_refused_by_name(kind: str) -> None:
    zones = Zones(map_id="hall", zone_set_id="z", zones=[Zone(zone_id="gate", zone_type=kind, vertices=VERTICES)])  # type: ignore[arg-type]
    with pytest.raises(InvalidInput, match=f"zone 'gate' is {kind}"):
        zones_of_vda5050(msgspec.json.encode(zones))


def test_a_soft_direction_is_refused_because_it_forbids_nothing() -> None:
    soft = Zone(zone_id="lane", zone_type="DIRECTED", vertices=VERTICES, direction=0.0, directed_limitation="SOFT")
    with pytest.raises(InvalidInput, match="zone 'lane' is DIRECTED with the limitation SOFT, which forbids nothing"):
        zones_of_vda5050(msgspec.json.encode(Zones(map_id="hall", zone_set_id="z", zones=[soft])))


def test_one_robot_at_a_time_is_released() -> None:
    gate = Zone(zone_id="gate", zone_type="RELEASE", vertices=VERTICES, release_loss_behavior="EVACUATE")
    (zone,) = zones_of_vda5050(msgspec.json.encode(Zones(map_id="hall", zone_set_id="z", zones=[gate]))).zones
    assert msgspec.to_builtins(zone.rule) == {"kind": "capacity", "name": "gate", "robots": 1}


@pytest.mark.parametrize(
    ("payload", "text"),
    [
        (b"{", "not valid JSON"),
        (b"\xff", "not valid JSON"),
        (b"[" * 100_000, "not valid JSON"),
        (b"[]", "not a zoneSet"),
        (b"{}", "not a zoneSet"),
        (b'{"zoneSet": 1}', "not a zoneSet"),
        (b'{"mapId": "a", "zoneSetId": "b", "zones": [{"zoneId": "c", "zoneType": "NEW"}]}', "NEW"),
        (
            b'{"mapId": "a", "zoneSetId": "b", "zones": [{"zoneId": "c", "zoneType": "SPEED_LIMIT",'
            b' "maximumSpeed": 0, "vertices": [{"x": 0, "y": 0}, {"x": 1, "y": 0}, {"x": 0, "y": 1}]}]}',
            "'c'",
        ),
    ],
)
def test_what_is_no_set_of_zones_is_refused_with_a_text(payload: bytes, text: str) -> None:
    with pytest.raises(InvalidInput, match=text):
        zones_of_vda5050(payload)


def zone_set(**fields: object) -> bytes:
    square = [{"x": 1.0, "y": 1.0}, {"x": 3.0, "y": 1.0}, {"x": 3.0, "y": 2.0}]
    zone = {"zoneId": "a", "zoneType": "DIRECTED", "vertices": square, "direction": 0.0, **fields}
    return json.dumps({"zoneSet": {"mapId": "office", "zoneSetId": "z", "zones": [zone]}}).encode()


@pytest.mark.parametrize("limits", [("RESTRICTED", False), ("STRICT", True)])
@pytest.mark.parametrize("name", ["limitation", "directedLimitation"])
def test_a_limitation_has_the_name_of_the_schema_of_3_0_0_or_that_of_the_text(
    name: str, limits: tuple[str, bool]
) -> None:
    (zone,) = zones_of_vda5050(zone_set(**{name: limits[0]})).zones
    assert isinstance(zone.rule, OneWay)
    assert zone.rule.strict is limits[1]


def test_the_name_of_the_text_counts_if_both_are_there() -> None:
    (zone,) = zones_of_vda5050(zone_set(limitation="RESTRICTED", directedLimitation="STRICT")).zones
    assert isinstance(zone.rule, OneWay)
    assert zone.rule.strict


@pytest.mark.parametrize(
    ("fields", "named"),
    [
        ({}, "without the field directedLimitation"),
        ({"limitation": None}, "without the field directedLimitation"),
        ({"limitation": "STRICT", "direction": None}, "without the field direction"),
        ({"zoneType": "SPEED_LIMIT"}, "without the field maximumSpeed"),
    ],
)
def test_a_field_that_is_missing_is_named_with_its_zone(fields: dict[str, object], named: str) -> None:
    with pytest.raises(InvalidInput, match=f"zone 'a' is .* {named}"):
        zones_of_vda5050(zone_set(**fields))


def test_a_set_is_written_with_the_names_of_both_schemas() -> None:
    zones = zones_of_vda5050(zone_set(limitation="STRICT"))
    (zone,) = json.loads(vda5050_of(zones, "office", "z", 0.0))["zoneSet"]["zones"]
    assert zone["limitation"] == zone["directedLimitation"] == "STRICT"
