"""Poses in a car, carried from landing to landing."""

import math

import pytest

from ppaas.buildings.building import Building, Floor, LiftSettings
from ppaas.buildings.layout import Landing, layout_of
from ppaas.buildings.riding.car_frame import carried, is_inside, places_in_car, turn_between
from ppaas.geometry import Pose2D
from ppaas.zones.shapes import LineString, Polygon
from ppaas.zones.zone import Door, LiftCar, Zone, ZoneSet


def landing_zones(frame: Pose2D, back: bool = False) -> ZoneSet:
    """Return the car and its door in a map whose frame lies there in the building; the car is around (1, 1)."""
    there = frame.inverse()

    def at(*points: tuple[float, float]) -> list[list[float]]:
        return [list((there @ Pose2D(x, y))[:2]) for x, y in points]

    y = -0.1 if back else 2.1
    return ZoneSet(
        [
            Zone(Polygon([at((0, 0), (2, 0), (2, 2), (0, 2), (0, 0))]), LiftCar(name="north", lift="north")),
            Zone(LineString(at((0.5, y), (1.5, y))), Door(name="door", lift="north")),
        ]
    )


def landings(frame: Pose2D, *, back: bool = False, said: Pose2D | None = None) -> tuple[Building, Landing, Landing]:
    anchor = tuple(frame if said is None else said)
    building = Building(floors=(Floor(name="L1", map="a"), Floor(name="L2", map="b", anchor=anchor)))
    zones = {"L1": landing_zones(Pose2D(0.0, 0.0)), "L2": landing_zones(frame, back)}
    first, second = layout_of(building, zones).landings["north"]
    return building, first, second


@pytest.mark.parametrize("back", [False, True])
@pytest.mark.parametrize("turn", [0.0, 0.7, math.pi / 2, -2.5])
def test_a_place_in_the_car_is_the_same_on_each_floor_whatever_the_frames_and_doors(turn: float, back: bool) -> None:
    frame = Pose2D(-7.0, 3.0, turn)
    building, first, second = landings(frame, back=back)
    inside = Pose2D(0.4, 1.5, 0.3)
    found = carried(building, first, second, inside)
    assert found == pytest.approx(frame.inverse() @ inside)
    assert carried(building, second, first, found) == pytest.approx(inside)
    assert is_inside(first, inside) and is_inside(second, found) and not is_inside(second, Pose2D(90.0, 0.0))


def test_headings_follow_the_drawn_doors_although_anchors_are_not_exact() -> None:
    building, first, second = landings(Pose2D(-7.0, 3.0, 0.7), said=Pose2D(0.0, 0.0, 1.2))
    assert turn_between(building, first, second) == pytest.approx(-0.7)


@pytest.mark.parametrize(("robots", "distance"), [(1, 2.0), (2, 1.0), (3, 1.0), (4, 1.0), (5, 2.0 / 3.0)])
def test_robots_that_share_a_car_have_places_apart_from_each_other_which_are_the_same_on_all_floors(
    robots: int, distance: float
) -> None:
    building, first, second = landings(Pose2D(5.0, -3.0, 0.7), back=True)
    shared = Building(floors=building.floors, lifts=(LiftSettings(lift="north", robots=robots),))
    places = places_in_car(shared, (first, second), first)
    assert len(places) == robots and all(is_inside(first, place) for place in places)
    apart = [one.distance_to(other) for one in places for other in places if one is not other]
    assert min(apart, default=2.0) == pytest.approx(distance)
    depths = [round(place.y, 6) for place in places]
    assert depths == sorted(depths), "those far from the door come first"
    for here, there in zip(places, places_in_car(shared, (first, second), second), strict=True):
        assert carried(shared, first, second, here)[:2] == pytest.approx(there[:2])
        assert there.theta == pytest.approx(second.car[2]), "they look out of the door"
