"""The navigator gets odometry and scans, and no true pose."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.navigation.barn.environment import Environment
from benchmarks.navigation.barn.jackal import NOISE
from benchmarks.navigation.barn.navigator import PERIOD, BarnNavigator, DeadEnds
from benchmarks.navigation.barn.run import make_navigator
from benchmarks.navigation.barn.scan_matching import ARC, DEPTH, MOST, smoothed
from benchmarks.navigation.barn.worlds import START, BarnWorld
from ppaas.costmap.costmap import LETHAL_OBSTACLE
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.geometry import Pose2D, poses_along
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, Twist, TwistWithCovariance
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from tests.support.world import barn, grids

GOAL = Pose2D(10.0, 0.0)
JACKAL = NOISE["hard"]


def pilot() -> BarnNavigator:
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


PLAN = poses_along(np.stack((np.arange(0.5, 4.0, 0.05), np.full(70, 1.0)), axis=1))


def costmap():
    data = np.zeros((40, 80), np.uint8)
    data[:, 24:27] = 200
    data[:, 30:32] = 120
    return grids.of(data, 0.05)


def test_the_narrowest_place_ahead_is_blocked_without_progress():
    dead_ends = DeadEnds()
    here = Pose2D(0.6, 1.0)
    assert not any(dead_ends.look(0.05 * cycle, here, PLAN, costmap()) for cycle in range(40))
    assert dead_ends.look(2.1, here, PLAN, costmap())
    [(x, y, radius)] = dead_ends.discs
    assert (x, y) == (pytest.approx(1.27, abs=0.08), 1.0)
    assert radius > 0.0
    assert not dead_ends.look(2.2, here, PLAN, costmap())
    dead_ends.forget()
    assert dead_ends.discs == []


def test_a_robot_that_makes_progress_blocks_nothing():
    dead_ends = DeadEnds()
    for cycle in range(200):
        assert not dead_ends.look(0.05 * cycle, Pose2D(0.5 + 0.015 * cycle, 1.0), PLAN, costmap())


def test_nothing_is_blocked_at_the_end_of_the_plan():
    dead_ends = DeadEnds()
    assert not any(dead_ends.look(0.1 * cycle, Pose2D(3.95, 1.0), PLAN, costmap()) for cycle in range(60))


def test_places_already_passed_are_not_blocked():
    dead_ends = DeadEnds()
    for cycle in range(100):
        dead_ends.look(0.05 * cycle, Pose2D(3.5 - 0.03 * cycle, 1.0, math.pi), PLAN, costmap())
    there = Pose2D(0.5, 1.0, 0.0)
    assert not any(dead_ends.look(5.0 + 0.05 * cycle, there, PLAN, costmap()) for cycle in range(100))
    assert dead_ends.discs == []


SPACING = math.radians(270.0) / 719
SOME = st.one_of(st.floats(0.05, 10.0), st.sampled_from([math.nan, math.inf, 0.0]))


def reading(ranges):
    return LaserReading(Pose2D(0.0, 0.0), SPACING * np.arange(len(ranges)), np.array(ranges, dtype=np.float64))


def naive(ranges):
    """Return the smoothed ranges, beam by beam."""
    found = list(ranges)
    for i, middle in enumerate(ranges):
        if not (math.isfinite(middle) and middle > 0.0):
            continue
        reach = min(MOST, math.floor(ARC / (middle * SPACING)))
        beside = ranges[max(i - reach, 0) : i + reach + 1]
        found[i] = np.mean([r for r in beside if math.isfinite(r) and r > 0.0 and abs(r - middle) <= DEPTH])
    return found


@given(st.lists(SOME, min_size=0, max_size=40))
def test_each_range_is_the_mean_of_its_neighbours_on_the_same_surface(ranges):
    assert smoothed(reading(ranges)).ranges == pytest.approx(naive(ranges), nan_ok=True, rel=1e-9)


def test_smoothing_removes_noise_of_a_near_surface():
    noisy = 0.5 + np.random.default_rng(1).normal(0.0, 0.02, 200)
    assert noisy.min() < 0.46
    assert np.abs(smoothed(reading(noisy)).ranges - 0.5).max() < 0.02


def test_ranges_are_not_averaged_across_an_edge():
    ranges = [0.6] * 30 + [2.0] * 30 + [math.inf] * 10
    assert smoothed(reading(ranges)).ranges == pytest.approx(ranges)


def test_ranges_are_unchanged_where_a_beam_is_wider_than_the_arc():
    ranges = [9.0, 9.05, 8.97, 9.02]
    assert smoothed(reading(ranges)).ranges.tolist() == ranges
