"""Robots that stand or creep for half an hour while their odometry drifts.

The cause of the drift: amcl looks at a scan only after odometry has turned by ``update_min_a``, and moves all particles
by that turn. Where the robot did not turn, none of them has its heading, and the sensor model picks the best of wrong
ones. Other members of the kind, each tested here: slow driving (0.01 m/s, 0.01 rad/s), turning in place, odometry that
drifts four times as fast, a robot that was driving before, scans that show nothing (the covariance must grow), people
around a standing robot, a robot that is pushed while its wheels stand, and a link that was down meanwhile.
"""

import math

import numpy as np
import pytest
from msgspec.structs import replace

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.generate import office, warehouse
from ppaas.maps.grid import GridMap
from ppaas.messages.sensor_msgs import LaserScan
from tests.support.world.localized_robot import Command, LocalizedRobot
from tests.support.world.places import free_pose
from tests.support.world.planar_world import error_of, walled_map
from tests.support.world.simulated_world import SimulatedWorld

HALF_AN_HOUR = 30.0
POSITION, HEADING = 0.05, math.radians(2.0)
"""Largest errors [m, rad]."""


def corridor() -> GridMap:
    """Return a corridor of 30 by 2 m with doorways."""
    boxes = [(x, y, x + 0.6, y + 0.3) for x in (3.0, 9.0, 16.0, 24.0) for y in (0.0, 1.7)]
    return walled_map(30.0, 2.0, boxes)


MAPS = {
    "office": lambda: (office(seed=1), 3),
    "corridor": lambda: (corridor(), 4),
    "hall": lambda: (warehouse(seed=1), 5),
}


def robot_on(name: str, *, drift: float = 1.0) -> LocalizedRobot:
    """Return a robot in one of the maps, whose odometry drifts as that of a Turtlebot, or faster."""
    grid, seed = MAPS[name]()
    return LocalizedRobot(SimulatedWorld(grid, free_pose(grid, seed), drift=drift, seed=seed, step=0.1))


def stand(_: Pose2D) -> tuple[float, float]:
    return 0.0, 0.0


def turn(_: Pose2D) -> tuple[float, float]:
    return 0.0, 0.01


def to_and_fro(robot: LocalizedRobot) -> Command:
    """Return a command that creeps 0.2 m forth and back, and turns as slowly meanwhile."""
    start = robot.clock()

    def creep(_: Pose2D) -> tuple[float, float]:
        forth = (robot.clock() - start) % 40.0 < 20.0
        return (0.01, 0.01) if forth else (-0.01, -0.01)

    return creep


@pytest.mark.parametrize("name", sorted(MAPS))
def test_a_robot_that_stands_for_half_an_hour_keeps_its_pose(name: str) -> None:
    robot = robot_on(name)
    errors = robot.run(HALF_AN_HOUR, seconds=2.0)
    turned = abs(wrap_angle(robot.world.odometry(0.0).pose.pose.planar().theta))
    assert turned > 5 * HEADING, "the odometry must turn, or the test is void"
    assert errors.position <= POSITION and errors.heading <= HEADING


@pytest.mark.parametrize("name", sorted(MAPS))
def test_a_robot_that_creeps_for_half_an_hour_keeps_its_pose(name: str) -> None:
    robot = robot_on(name)
    errors = robot.run(HALF_AN_HOUR, to_and_fro(robot), seconds=2.0)
    assert errors.position <= POSITION and errors.heading <= HEADING


def test_a_robot_that_turns_very_slowly_keeps_its_pose() -> None:
    errors = robot_on("office").run(HALF_AN_HOUR, turn, seconds=2.0)
    assert errors.position <= POSITION and errors.heading <= HEADING


@pytest.mark.parametrize("name", sorted(MAPS))
def test_a_robot_whose_gyro_drifts_four_times_as_fast_keeps_its_pose(name: str) -> None:
    errors = robot_on(name, drift=4.0).run(10.0, seconds=2.0)
    assert errors.position <= POSITION and errors.heading <= HEADING


def blind(scan: LaserScan) -> LaserScan:
    """Return a scan of people all around the robot, which differs from the one before."""
    random = np.random.default_rng(scan.header.stamp.secs)
    return replace(scan, ranges=random.uniform(0.4, 0.7, len(scan.ranges)).tolist())


def test_the_covariance_grows_while_scans_show_nothing_of_the_map() -> None:
    robot = robot_on("office", drift=4.0)
    robot.run(0.2)
    sure = robot.heading_deviation
    robot.change = blind
    for _ in range(10):
        robot.run(0.5)
        assert error_of(robot.pose, robot.world.pose)[1] < 3.0 * robot.heading_deviation
    assert robot.heading_deviation > 3 * sure


def test_the_heading_is_found_again_after_scans_showed_nothing_of_the_map() -> None:
    robot = robot_on("office", drift=4.0)
    robot.run(0.2)
    robot.change = blind
    robot.run(5.0)
    robot.change = lambda scan: scan
    robot.run(0.3)
    position, heading = error_of(robot.pose, robot.world.pose)
    assert position <= POSITION and heading <= HEADING


def test_a_robot_that_was_not_heard_for_minutes_keeps_its_heading() -> None:
    robot = robot_on("office", drift=4.0)
    robot.run(0.2)
    robot.step(seconds=300.0)
    robot.run(0.2)
    position, heading = error_of(robot.pose, robot.world.pose)
    assert position <= POSITION and heading <= HEADING


def test_a_robot_that_is_turned_by_hand_is_followed() -> None:
    robot = robot_on("office")
    robot.run(0.5)
    pose = robot.world.pose
    robot.world.carry_to(Pose2D(pose.x + 0.05, pose.y - 0.03, pose.theta + 0.25))
    robot.run(0.5)
    position, heading = error_of(robot.pose, robot.world.pose)
    assert position <= 2 * POSITION and heading <= HEADING


def test_a_robot_that_stands_costs_an_alignment_a_second_at_most() -> None:
    robot = robot_on("office")
    robot.run(1.0, seconds=0.1)
    assert len(robot.told) == 600
    assert robot.clouds == 1
