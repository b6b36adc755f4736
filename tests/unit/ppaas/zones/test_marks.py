"""Marks on a map, such as doors, lifts and docks: zones that are places, and no rules."""

import json
from typing import Any

import pytest

from ppaas.errors import InvalidZones
from ppaas.zones.reading import geojson_of, zones_of
from ppaas.zones.zone import Dock, Door, LiftCar, Passage

POINT = {"type": "Point", "coordinates": [3.0, 4.0]}
LINE = {"type": "LineString", "coordinates": [[0.0, 0.0], [1.0, 0.0]]}
SQUARE = {"type": "Polygon", "coordinates": [[[0, 0], [2, 0], [2, 2], [0, 2], [0, 0]]]}

MARKS = {
    "door": (LINE, {"lift": "north"}, Door(name="a", lift="north")),
    "lift": (SQUARE, {"lift": "north"}, LiftCar(name="a", lift="north")),
    "passage": (POINT, {"way": "ramp 1", "yaw": 1.5}, Passage(name="a", way="ramp 1", yaw=1.5)),
    "dock": (POINT, {"yaw": 0.5, "charges": False}, Dock(name="a", yaw=0.5, charges=False)),
}


def text(geometry: dict[str, Any], **properties: Any) -> str:
    feature = {"type": "Feature", "geometry": geometry, "properties": {"name": "a", **properties}}
    return json.dumps({"type": "FeatureCollection", "features": [feature]})


@pytest.mark.parametrize("kind", MARKS)
def test_a_mark_is_read_and_written(kind: str) -> None:
    geometry, properties, rule = MARKS[kind]
    zones = zones_of(text(geometry, kind=kind, **properties))
    assert [zone.rule for zone in zones.zones] == [rule]
    assert zones_of(geojson_of(zones)) == zones


@pytest.mark.parametrize("kind", MARKS)
def test_a_mark_of_another_shape_is_refused(kind: str) -> None:
    geometry, properties, _ = MARKS[kind]
    wrong = SQUARE if geometry is POINT else POINT
    with pytest.raises(InvalidZones, match="is a point, and all other zones"):
        zones_of(text(wrong, kind=kind, **properties))


def test_a_mark_has_no_times() -> None:
    with pytest.raises(InvalidZones, match="a door has no times; it is a place"):
        zones_of(text(LINE, kind="door", times=[{}]))


def test_a_door_is_one_line() -> None:
    two = {"type": "MultiLineString", "coordinates": [LINE["coordinates"], [[5.0, 5.0], [6.0, 5.0]]]}
    with pytest.raises(InvalidZones, match="a door is one line"):
        zones_of(text(two, kind="door"))


def test_a_car_is_one_polygon() -> None:
    apart = [[[5.0, 5.0], [6.0, 5.0], [6.0, 6.0], [5.0, 5.0]]]
    two = {"type": "MultiPolygon", "coordinates": [SQUARE["coordinates"], apart]}
    with pytest.raises(InvalidZones, match="the car of a lift is one polygon"):
        zones_of(text(two, kind="lift"))


def test_a_car_has_the_id_of_its_zone_unless_it_names_another() -> None:
    assert LiftCar(name="north").lift_id == "north"
    assert LiftCar(name="north, floor 1", lift="north").lift_id == "north"
