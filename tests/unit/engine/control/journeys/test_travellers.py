"""What robots can do in a building: their speed, their labels, and whether they climb stairs."""

from typing import Any

import numpy as np
import pytest

from engine.control.journeys.travellers import traveller_of
from ppaas.buildings.building import Building, Floor, WaySettings
from ppaas.buildings.layout import layout_of
from ppaas.buildings.planning.network import BuildingNetwork
from ppaas.buildings.planning.times import BuildingState, BuildingTimes
from ppaas.clone.robot_body import robot_body
from ppaas.zones.shapes import Point
from ppaas.zones.zone import Passage, Zone, ZoneSet
from storage.records import RobotRecord


def record(**fields: Any) -> RobotRecord:
    return RobotRecord("tb1", "ann", "house", **fields)


@pytest.mark.parametrize(
    ("fields", "speed"),
    [
        ({}, robot_body("turtlebot2").limits.max_vel_x),
        ({"parameters": {"dwa": {"max_vel_x": 0.2}}}, 0.2),
        ({"parameters": {"DWAPlannerROS": {"max_vel_x": 0.3}}}, 0.3),
        ({"parameters": {"move_base": {"base_local_planner": "mppi"}, "mppi": {"max_vel_x": 0.9}}}, 0.9),
        ({"parameters": {"mppi": {"max_vel_x": 0.9}}}, robot_body("turtlebot2").limits.max_vel_x),
        ({"parameters": {"dwa": {"max_vel_x": "fast"}}}, robot_body("turtlebot2").limits.max_vel_x),
    ],
)
def test_the_speed_is_the_limit_of_the_local_planner(fields: dict[str, Any], speed: float) -> None:
    assert traveller_of(record(**fields), None, ()).speed == pytest.approx(speed)


@pytest.mark.parametrize(
    ("properties", "takes"),
    [({}, False), ({"stairs": "yes"}, True), ({"stairs": True}, True), ({"stairs": "no"}, False)],
)
def test_only_a_robot_that_climbs_stairs_is_led_over_them(properties: dict[str, Any], takes: bool) -> None:
    building = Building(
        floors=(Floor(name="L1", map="house"), Floor(name="L2", map="loft", elevation=3.0)),
        ways=(WaySettings(way="up", kind="stairs"),),
    )
    ends = {"L1": (1.0, 0.0), "L2": (1.0, 3.14)}
    zones = {
        floor: ZoneSet([Zone(Point([x, 2.0]), Passage(name="end", way="up", yaw=yaw))])
        for floor, (x, yaw) in ends.items()
    }
    network = BuildingNetwork(layout_of(building, zones))
    times = BuildingTimes(BuildingState(network), traveller_of(record(properties=properties), None, ()))
    assert bool((np.isfinite(times.between(0, 1))).any()) is takes


def test_labels_are_the_properties_and_what_is_avoided_is_not_taken() -> None:
    found = traveller_of(record(properties={"legs": 4, "nested": {}}), None, ["north"])
    assert (found.labels, found.avoid) == ({"legs": "4"}, frozenset({"north"}))
