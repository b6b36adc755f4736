"""Layouts of buildings: landings, ways and docks from the zones of the maps, and what is left out."""

import math
from typing import Any

import pytest

from ppaas.buildings.building import Building, DoorSettings, Floor, LiftSettings, WaySettings
from ppaas.buildings.layout import BEFORE_DOOR, layout_of
from ppaas.zones.schedule import Hours
from ppaas.zones.shapes import LineString, Point, Polygon
from ppaas.zones.zone import Dock, Door, LiftCar, OneWay, Passage, Zone, ZoneSet

TWO = Building(floors=(Floor(name="L1", map="a"), Floor(name="L2", map="b", elevation=4.0)))


def car(x: float = 0.0, name: str = "north") -> Zone:
    ring = [[x, 0.0], [x + 2.0, 0.0], [x + 2.0, 2.0], [x, 2.0], [x, 0.0]]
    return Zone(Polygon([ring]), LiftCar(name=name, lift="north"))


def door(x: float = 0.0, lift: str = "north") -> Zone:
    return Zone(LineString([[x + 0.5, 2.1], [x + 1.5, 2.1]]), Door(name="landing door", lift=lift))


def passage(way: str, x: float = 5.0) -> Zone:
    return Zone(Point([x, 5.0]), Passage(name=f"end {x}", way=way, yaw=0.0))


def layout(one: list[Zone], other: list[Zone], **changes: Any) -> Any:
    building = Building(floors=TWO.floors, **changes)
    return layout_of(building, {"L1": ZoneSet(one), "L2": ZoneSet(other)})


def test_a_lift_joins_its_landings() -> None:
    found = layout([car(), door()], [car(10.0), door(10.0)])
    first, second = found.landings["north"]
    assert (first.floor, second.floor) == ("L1", "L2")
    assert first.car == pytest.approx((1.0, 1.0, math.pi / 2))
    assert first.wait == pytest.approx((1.0, 2.1 + BEFORE_DOOR, -math.pi / 2))
    assert second.car[0] == pytest.approx(11.0)
    assert first.outline == ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0))
    assert found.warnings == ()


def test_a_lift_with_two_doors_on_a_floor_has_two_landings_there() -> None:
    back = Zone(LineString([[0.5, -0.1], [1.5, -0.1]]), Door(name="back", lift="north"))
    found = layout([car(), door(), back], [car(), door()])
    assert [landing.door.door for landing in found.landings["north"]] == ["landing door", "back", "landing door"]
    assert found.landings["north"][1].car[2] == pytest.approx(-math.pi / 2)


NOON = [Hours(begin="12:00", end="13:00")]


@pytest.mark.parametrize(
    ("line", "times", "direction"),
    [
        ([[1.0, 0.0], [1.0, 4.0]], [], math.pi / 2),
        ([[1.0, 4.0], [1.0, 0.0]], [], -math.pi / 2),
        ([[1.0, 0.0], [1.0, 4.0]], NOON, None),
        ([[9.0, 0.0], [9.0, 4.0]], [], None),
    ],
)
def test_a_one_way_zone_over_a_door_makes_it_a_gate(
    line: list[list[float]], times: list[Hours], direction: float | None
) -> None:
    way = Zone(LineString(line), OneWay(name="out", width=0.5, times=times))
    found = layout([door(lift=""), way], [])
    assert found.doors[0].one_way == (direction if direction is None else pytest.approx(direction))


def test_a_one_way_zone_does_not_change_the_door_of_a_lift() -> None:
    way = Zone(LineString([[1.0, 0.0], [1.0, 4.0]]), OneWay(name="out", width=0.5))
    assert layout([car(), door(), way], [car(), door()]).landings["north"][0].door.one_way is None


@pytest.mark.parametrize(
    ("one", "other", "warning"),
    [
        ([car(), door()], [], "lift 'north' stops on one floor only"),
        ([car(), door()], [car()], "floor 'L2': lift 'north' has no door there"),
        ([car(), car(name="again"), door()], [car(), door()], "two zones are the car of lift 'north'; 'again'"),
        ([car(), door(10.0)], [car(), door()], "is 9.0 m from the car of lift 'north'"),
        ([passage("ramp")], [], "way 'ramp' needs one end on each of two floors"),
    ],
)
def test_what_is_left_out_is_named(one: list[Zone], other: list[Zone], warning: str) -> None:
    assert any(warning in text for text in layout(one, other).warnings)


def test_settings_without_a_place_are_named() -> None:
    found = layout(
        [],
        [],
        lifts=(LiftSettings(lift="south"),),
        ways=(WaySettings(way="stairs"),),
        doors=(DoorSettings(floor="L1", door="main"),),
    )
    assert [text.partition(":")[0] for text in found.warnings] == [
        "no two maps have a landing of lift 'south'",
        "no maps have both ends of way 'stairs'",
        "floor 'L1' has no door 'main'",
    ]


def test_ways_doors_and_docks() -> None:
    dock = Zone(Point([1.0, 8.0]), Dock(name="charger 1", yaw=0.5, dock_type="v_shape"))
    found = layout([passage("ramp"), door(lift=""), dock], [passage("ramp", 7.0)])
    assert [end.place for end in found.ways["ramp"]] == [(5.0, 5.0, 0.0), (7.0, 5.0, 0.0)]
    assert [(each.floor, each.middle) for each in found.doors] == [("L1", (1.0, 2.1))]
    assert [(each.dock, each.place, each.charges) for each in found.docks] == [("charger 1", (1.0, 8.0, 0.5), True)]
