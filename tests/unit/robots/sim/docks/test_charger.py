"""Simulated chargers."""

import math

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import Twist, Vector3
from robots.sim.docks.charger import Charger, ChargerFault, ChargerModel
from robots.sim.laser import LaserModel
from robots.sim.robot import SimulatedRobotModel
from robots.sim.world import World
from tests.support.world.rooms import room

DOCKED = Pose2D(4.0, 3.0, 0.5)


@pytest.mark.parametrize(
    ("off", "touches"),
    [
        ((0.0, 0.0, 0.0), True),
        ((-0.01, 0.019, 0.1), True),
        ((-0.02, 0.0, 0.0), False),
        ((0.0, 0.025, 0.0), False),
        ((0.0, 0.0, 0.2), False),
        ((0.0, 0.0, math.pi), False),
    ],
)
def test_contacts_touch_within_their_tolerance(off: tuple[float, float, float], touches: bool) -> None:
    charger = Charger(DOCKED, 0.18)
    robot = DOCKED @ Pose2D(*off)
    assert charger.touches(robot) is touches
    assert charger.current(robot) == (3.0 if touches else 0.0)
    assert charger.reports_charging(robot) is touches


@pytest.mark.parametrize(("fault", "reports"), [(ChargerFault.DEAD, False), (ChargerFault.LIAR, True)])
def test_faulty_chargers_give_no_current(fault: ChargerFault, reports: bool) -> None:
    charger = Charger(DOCKED, 0.18, fault=fault)
    assert charger.current(DOCKED) == 0.0
    assert charger.reports_charging(DOCKED) is reports


def test_a_robot_sees_the_face_and_is_stopped_by_it() -> None:
    world = World(room(8.0, 6.0))
    world.add_furniture(Charger(DOCKED, 0.18).body())
    robot = world.add_robot(DOCKED @ Pose2D(-0.3, 0.0), SimulatedRobotModel(laser=LaserModel(sigma=0.0)))
    ahead = robot.scan().ranges[180]
    assert ahead == pytest.approx(0.48, abs=0.01)
    for _ in range(200):
        robot.command(Twist(Vector3(x=0.2)))
        world.step()
    assert (DOCKED.inverse() @ robot.base.pose).x == pytest.approx(0.0, abs=0.01)


def test_a_v_is_open_to_the_robot() -> None:
    discs = Charger(Pose2D(0.0, 0.0), 0.2, ChargerModel(angle=2.0, width=0.4)).body().discs
    at_the_middle = min(x for x, y, _ in discs if abs(y) < 0.02)
    at_the_ends = min(x for x, y, _ in discs if abs(y) > 0.18)
    assert at_the_middle == pytest.approx(0.21, abs=0.02)
    assert at_the_ends == pytest.approx(0.2 - 0.2 / math.tan(1.0), abs=0.02)
