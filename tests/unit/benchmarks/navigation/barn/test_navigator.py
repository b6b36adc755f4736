"""The navigator gets odometry and scans, and no true pose."""

import math

import numpy as np

from benchmarks.navigation.barn.environment import Environment
from benchmarks.navigation.barn.jackal import NOISE
from benchmarks.navigation.barn.navigator import PERIOD, Navigator
from benchmarks.navigation.barn.run import make_navigator
from benchmarks.navigation.barn.worlds import START, BarnWorld
from ppaas.costmap.costmap import LETHAL_OBSTACLE
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, Twist, TwistWithCovariance
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from tests.support.world import barn

GOAL = Pose2D(10.0, 0.0)
JACKAL = NOISE["hard"]


def pilot() -> Navigator:
    return make_navigator("mppi", GOAL, JACKAL.drive)


def standing() -> Odometry:
    return Odometry(
        header=Header(frame_id="odom"), child_frame_id="base_link",
        pose=PoseWithCovariance(Pose.of(Pose2D(0.0, 0.0, 0.0))), twist=TwistWithCovariance(Twist()),
    )  # fmt: skip


def scan(ranges: list[float | None]) -> LaserScan:
    return LaserScan(
        header=Header(frame_id="base_link"), angle_min=-math.pi / 2, angle_max=math.pi / 2,
        angle_increment=math.pi / (len(ranges) - 1), range_min=0.1, range_max=10.0, ranges=ranges,
    )  # fmt: skip


def moved(world: BarnWorld, by: Pose2D) -> BarnWorld:
    places = [by @ Pose2D(x, y) for x, y in world.cylinders]
    return BarnWorld(world.world, world.radius, [(place.x, place.y) for place in places], world.path_length)


def commands(world: BarnWorld, start: Pose2D) -> list[tuple[float, float]]:
    course, driver = Environment(world, JACKAL, np.random.default_rng(5), start), pilot()
    sent = []
    for _ in range(12):
        twist = driver.drive(course.odometry(), course.scan())
        sent.append((twist.linear.x, twist.angular.z))
        course.command(twist)
        for _ in range(round(PERIOD / 0.01)):
            course.step()
    return sent


def test_commands_do_not_depend_on_the_pose_of_the_world() -> None:
    """A world that is moved by 40 m and rotated by 180° would reveal any use of the true pose."""
    there = Pose2D(40.0, -25.0, math.pi)
    here, elsewhere = commands(barn.world(), START), commands(moved(barn.world(), there), there @ START)
    assert np.allclose(here, elsewhere, atol=1e-6)
    assert max(linear for linear, _ in here) > 1.0


def test_the_navigator_holds_no_environment_or_world() -> None:
    driver = pilot()
    twist = driver.drive(standing(), scan([None] * 91))
    assert twist.linear.x > 0.0
    held = [value for value in vars(driver).values() if isinstance(value, Environment | BarnWorld)]
    assert held == []


def test_the_navigator_stops_inside_a_closed_wall() -> None:
    driver = pilot()
    twists = [driver.drive(standing(), scan([0.4] * 91)) for _ in range(4)]
    assert max(abs(twist.linear.x) for twist in twists) < 0.5


def test_the_navigator_drives_without_scans_by_its_obstacle_memory() -> None:
    driver = pilot()
    driver.drive(standing(), scan([None] * 91))
    assert driver.drive(standing(), scan([math.nan] * 91)).linear.x > 0.0


def test_laser_noise_does_not_shrink_gaps() -> None:
    driver = pilot()
    driver.drive(standing(), scan((0.8 + np.random.default_rng(3).normal(0.0, 0.02, 720)).tolist()))
    assert driver.costs is not None
    cells = np.argwhere(driver.costs.data == LETHAL_OBSTACLE)
    distances = np.hypot(*driver.costs.info.to_world(cells).T)
    assert len(distances) > 20
    assert 0.75 < distances.min() < distances.max() < 0.85
