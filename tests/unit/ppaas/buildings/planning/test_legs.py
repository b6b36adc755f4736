"""Legs of a route: what a robot does, from where to where, and with which headings."""

import math

import pytest

from ppaas.buildings.planning.legs import legs_of
from ppaas.buildings.planning.times import Traveller
from ppaas.geometry import wrap_angle
from tests.unit.ppaas.buildings.planning.random_buildings import two_floors


def test_a_robot_enters_a_car_with_the_heading_into_it_and_leaves_with_the_opposite_one() -> None:
    planner = two_floors().planner()
    times = planner.times(Traveller(speed=0.5))
    found = planner.plan(times, ("L0", 0.5, 5.5), ("L1", 5.0, 5.0))
    assert found is not None
    legs = legs_of(times, found.route, found.goal, ((0.5, 5.5, 1.0), (5.0, 5.0, 2.0)))
    assert [(leg.kind, leg.name, leg.floor, leg.to_floor) for leg in legs] == [
        ("drive", "", "L0", "L0"), ("lift", "north", "L0", "L1"), ("drive", "", "L1", "L1"),
    ]  # fmt: skip
    to_car, ride, from_car = legs
    assert (to_car.start, from_car.goal) == ((0.5, 5.5, 1.0), (5.0, 5.0, 2.0))
    assert ride.start == to_car.goal
    assert ride.goal == from_car.start
    assert ride.start[2] == pytest.approx(-math.pi / 2.0)
    assert abs(wrap_angle(ride.goal[2] - ride.start[2])) == pytest.approx(math.pi)
    assert to_car.seconds == pytest.approx(to_car.length / 0.5)


def test_a_direct_drive_is_one_leg() -> None:
    planner = two_floors().planner()
    times = planner.times(Traveller(speed=2.0))
    found = planner.plan(times, ("L1", 0.1, 5.1), ("L1", 3.1, 5.1))
    assert found is not None
    [leg] = legs_of(times, found.route, found.goal, ((0.1, 5.1, 0.0), (3.1, 5.1, 0.0)))
    assert (leg.kind, leg.length, leg.seconds) == ("drive", pytest.approx(3.0), pytest.approx(1.5))
