"""What may be wrong in a building: floors that nothing leads to, and anchors that do not agree."""

import math

import pytest

from ppaas.buildings.building import Building, Floor
from ppaas.buildings.checks import in_building, reachable_floors, warnings_of
from ppaas.buildings.layout import BuildingLayout, layout_of
from ppaas.zones.shapes import LineString, Point, Polygon
from ppaas.zones.zone import Door, LiftCar, Passage, Zone, ZoneSet


def lift(x: float = 0.0) -> list[Zone]:
    ring = [[x, 0.0], [x + 2.0, 0.0], [x + 2.0, 2.0], [x, 2.0], [x, 0.0]]
    line = [[x + 0.5, 2.1], [x + 1.5, 2.1]]
    return [
        Zone(Polygon([ring]), LiftCar(name="north")),
        Zone(LineString(line), Door(name="door", lift="north")),
    ]


def ramp() -> list[Zone]:
    return [Zone(Point([5.0, 5.0]), Passage(name="end", way="ramp", yaw=0.0))]


def layout(*floors: list[Zone], anchors: dict[int, tuple[float, float, float]] | None = None) -> BuildingLayout:
    anchors = anchors or {}
    building = Building(
        floors=tuple(
            Floor(name=f"L{at}", map=f"m{at}", elevation=4.0 * at, anchor=anchors.get(at, (0.0, 0.0, 0.0)))
            for at in range(len(floors))
        )
    )
    return layout_of(building, {f"L{at}": ZoneSet(zones) for at, zones in enumerate(floors)})


def test_floors_are_reached_by_lifts_that_skip_floors_and_by_ways() -> None:
    found = layout(lift(), ramp(), lift() + ramp())
    assert reachable_floors(found, "L0") == {"L0", "L1", "L2"}
    assert warnings_of(found) == ()


def test_a_floor_that_nothing_leads_to_is_named() -> None:
    found = layout(lift(), [], lift())
    assert reachable_floors(found, "L1") == {"L1"}
    assert warnings_of(found) == ("floor 'L1' cannot be reached from 'L0': no lift and no way leads there",)


def test_cars_that_are_apart_in_the_building_are_named() -> None:
    [text] = warnings_of(layout(lift(), lift(3.0)))
    assert text.startswith("lift 'north': its car on floor 'L1' is 3.00 m from where it is on 'L0'")
    assert warnings_of(layout(lift(), lift(3.0), anchors={1: (-3.0, 0.0, 0.0)})) == ()


def test_anchors_turn_and_move_a_map() -> None:
    building = Building(floors=(Floor(name="L1", map="m", anchor=(10.0, 20.0, math.pi / 2)),))
    assert in_building(building, "L1", (1.0, 2.0, 3.0)) == pytest.approx((8.0, 21.0, 3.0 + math.pi / 2 - math.tau))
