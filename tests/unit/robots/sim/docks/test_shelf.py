"""Simulated shelves on the lifts of robots."""

import math

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.zones.shapes import Point
from ppaas.zones.zone import Dock, Zone, ZoneSet
from robots.sim.docks.fitting import fit_docks
from robots.sim.docks.shelf import Shelf, ShelfLift, shelf_under
from robots.sim.world import World
from tests.support.world.planar_world import walled_map

UNDER = Pose2D(3.0, 2.0, 0.0)
LOAD = [[0.5, 0.35], [-0.5, 0.35], [-0.5, -0.35], [0.5, -0.35]]


class Scene:
    """A robot under a shelf in a room of 6 m × 4 m."""

    def __init__(self, at: Pose2D = UNDER) -> None:
        self.world = World(walled_map(6.0, 4.0, []))
        self.shelf = Shelf(self.world, UNDER)
        self.robot = self.world.add_robot(at)
        self.lift = ShelfLift(self.robot, [self.shelf])

    def run(self, seconds: float, speed: float = 0.0, turn: float = 0.0) -> None:
        """Drive for a time [s]."""
        for _ in range(round(seconds / self.world.dt)):
            self.robot.command(Twist(Vector3(x=speed), Vector3(z=turn)))
            self.world.step()
            self.lift.after_step(self.world.dt)

    def raise_lift(self) -> None:
        """Lift what is above."""
        self.lift.command(True)
        self.run(1.2)


def test_a_shelf_on_the_lift_moves_with_the_robot_and_stays_where_it_is_set_down() -> None:
    scene = Scene()
    scene.raise_lift()
    assert scene.lift.up and scene.lift.shelf is scene.shelf
    scene.run(3.0, 0.3, 0.2)
    scene.run(0.5)
    at = scene.robot.base.pose
    assert scene.shelf.pose.distance_to(at) < 0.01 and abs(scene.shelf.pose.theta - at.theta) < 0.02
    assert scene.shelf.pose.distance_to(UNDER) > 0.7
    scene.lift.command(False)
    scene.run(1.2)
    scene.run(2.0, -0.3)
    assert not scene.lift.up and scene.lift.shelf is None
    assert scene.shelf.pose.distance_to(at) < 0.01


def test_its_legs_touch_what_they_are_carried_against_and_lasers_see_them() -> None:
    scene = Scene()
    scene.raise_lift()
    assert min(each for each in scene.robot.scan().ranges if each is not None) == pytest.approx(0.5, abs=0.1)
    scene.run(10.0, 0.4)
    assert scene.world.contacts.wall_contacts[0] >= 1
    assert scene.robot.base.pose.x < 6.0 - 0.4, "the wall holds the shelf"


@pytest.mark.parametrize("at", [Pose2D(3.0, 2.2, 0.0), Pose2D(3.3, 2.0, 0.0), Pose2D(3.0, 2.0, 0.5 * math.pi)])
def test_a_lift_that_is_not_under_the_shelf_lifts_nothing(at: Pose2D) -> None:
    scene = Scene(at)
    scene.raise_lift()
    assert scene.lift.up and scene.lift.shelf is None


def test_a_jammed_lift_does_not_move() -> None:
    scene = Scene()
    scene.lift.jammed = True
    scene.raise_lift()
    assert not scene.lift.up


def test_shelves_stand_at_the_docks_of_loads() -> None:
    world = World(walled_map(6.0, 4.0, []))
    zones = ZoneSet([
        Zone(Point([3.0, 2.0]), Dock(name="s", yaw=0.0, dock_type="shelf", charges=False)),
        Zone(Point([5.0, 1.0]), Dock(name="c", yaw=0.0)),
    ])  # fmt: skip
    parameters = {"docking_server": {"dock_types": {"shelf": {"detection": "legs", "load": LOAD}}}}
    docks = fit_docks(world, zones, parameters)
    assert len(docks.chargers) == 1 and [shelf.pose for shelf in docks.shelves] == [Pose2D(3.0, 2.0, 0.0)]
    assert docks.parts_of(world.add_robot(Pose2D(1.0, 1.0))).lift is not None
    other = shelf_under(world, Pose2D(1.0, 2.0, 0.0), tuple((x + 0.2, y) for x, y in LOAD))
    assert np.allclose(other.pose, (1.2, 2.0, 0.0)) and (other.length, other.width) == pytest.approx((1.0, 0.7))
