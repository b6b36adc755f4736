"""Alignment of a scan near an expected pose; a blind laser and one with nothing in reach."""

import math

import numpy as np
import pytest
from msgspec.structs import replace

from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.localization.beams import choose_beams, scan_points
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.scan_match import ScanMatch, align, check_plausible
from ppaas.maps.grid import GridMap
from ppaas.messages.sensor_msgs import LaserScan
from tests.support.world.planar_world import World, error_of, walled_map

ROOM = walled_map(8.0, 6.0, [(3.0, 0.0, 3.4, 2.0), (6.0, 4.0, 7.0, 4.5)])
CORRIDOR = walled_map(60.0, 2.0, [])
HERE = Pose2D(2.0, 3.0, 0.7)
USUAL = np.array((0.05, 0.05, 0.05))


def match_of(grid: GridMap) -> ScanMatch:
    return ScanMatch(build_layers(grid), AmclParameters())


def points_at(grid: GridMap, pose: Pose2D) -> np.ndarray:
    """Return what a laser sees from a pose."""
    return choose_beams(scan_points(World(grid, pose).scan(0.0), Pose2D(0.0, 0.0)), 180)


@pytest.mark.parametrize("away", [(0.0, 0.0, 0.0), (0.05, -0.04, 0.03), (-0.06, 0.05, -0.06)])
def test_the_true_pose_is_found_near_the_expected_one(away: tuple[float, float, float]) -> None:
    expected = Pose2D(HERE.x + away[0], HERE.y + away[1], HERE.theta + away[2])
    found = align(match_of(ROOM), points_at(ROOM, HERE), expected, USUAL)
    position, heading = error_of(found.pose, HERE)
    assert position < 0.03 and heading < math.radians(0.7)
    assert found.fit > 0.9


def test_along_a_corridor_the_pose_stays_the_expected_one() -> None:
    there = Pose2D(30.0, 1.0, 0.1)
    expected = Pose2D(30.05, 1.04, 0.13)
    found = align(match_of(CORRIDOR), points_at(CORRIDOR, there), expected, USUAL)
    assert abs(found.pose.x - expected.x) < 0.02, "no scan tells it"
    assert abs(found.pose.y - there.y) < 0.02 and abs(found.pose.theta - there.theta) < math.radians(0.7)
    along, across = np.sqrt(np.diag(found.covariance)[:2])
    assert along > 0.8 * USUAL[0] > 1.5 * across


def test_a_heading_far_from_the_expected_one_is_found_if_it_is_that_unsure() -> None:
    expected = Pose2D(HERE.x, HERE.y, HERE.theta + 1.2)
    found = align(match_of(ROOM), points_at(ROOM, HERE), expected, np.array((0.002, 0.002, 0.8)))
    assert error_of(found.pose, HERE)[1] < math.radians(1.0)
    assert math.sqrt(found.covariance[2, 2]) < math.radians(2.0)


def test_a_robot_that_was_pushed_is_followed_although_it_was_expected_not_to_move() -> None:
    expected = Pose2D(HERE.x + 0.06, HERE.y - 0.05, HERE.theta + 0.15)
    found = align(match_of(ROOM), points_at(ROOM, HERE), expected, np.array((0.002, 0.002, 0.005)))
    position, heading = error_of(found.pose, HERE)
    assert position < 0.05 and heading < math.radians(1.0)


def test_where_nothing_is_near_the_points_the_heading_is_as_unsure_as_before() -> None:
    points = 0.5 * points_at(ROOM, HERE) / np.linalg.norm(points_at(ROOM, HERE), axis=1, keepdims=True)
    found = align(match_of(ROOM), points, HERE, USUAL)
    assert found.fit < 0.1
    assert math.sqrt(found.covariance[2, 2]) > 0.8 * USUAL[2]


def test_equal_scans_give_equal_poses() -> None:
    match, points = match_of(ROOM), points_at(ROOM, HERE)
    first, second = (align(match, points, HERE, USUAL) for _ in range(2))
    assert first.pose == second.pose


LAYERS = build_layers(walled_map(30, 30, [(2, 14, 2.2, 16)]))
MIDDLE, CORNER = Pose2D(15.0, 15.0, 0.3), Pose2D(1.5, 1.5, 2.0)


def scan_of(ranges: float | None, *, first: float = -math.pi, last: float = math.pi) -> LaserScan:
    scan = World(LAYERS.grid, MIDDLE).scan(100.0)
    step = (last - first) / (len(scan.ranges) - 1)
    return replace(scan, ranges=[ranges] * len(scan.ranges), angle_min=first, angle_max=last, angle_increment=step)


NOTHING = pytest.mark.parametrize("nothing", [None, math.nan, math.inf, 8.0, 9.5, 0.0, -3.0, 0.049])


@NOTHING
def test_empty_scan_is_plausible_without_obstacles_in_range(nothing):
    check_plausible(scan_of(nothing), LAYERS, lambda: MIDDLE)


@NOTHING
def test_empty_scan_is_refused_among_walls(nothing):
    with pytest.raises(InvalidInput, match="no beam of the scan has a reading"):
        check_plausible(scan_of(nothing), LAYERS, lambda: CORNER)


AHEAD = {"first": -0.3, "last": 0.3}


def test_only_walls_in_the_field_of_view_are_expected():
    check_plausible(scan_of(None, **AHEAD), LAYERS, lambda: Pose2D(CORNER.x, CORNER.y, math.pi / 4))
    with pytest.raises(InvalidInput, match="by the map half of them should"):
        check_plausible(scan_of(None, **AHEAD), LAYERS, lambda: Pose2D(CORNER.x, CORNER.y, 1.25 * math.pi))


def test_wall_within_range_min_is_not_expected():
    before_the_wall = Pose2D(0.5, 12.0, math.pi)
    scan = scan_of(math.nan, **AHEAD)
    with pytest.raises(InvalidInput):
        check_plausible(scan, LAYERS, lambda: before_the_wall)
    check_plausible(replace(scan, range_min=0.45), LAYERS, lambda: before_the_wall)


def test_unlocalized_robot_is_not_checked():
    check_plausible(scan_of(None), LAYERS, lambda: None)


@pytest.mark.parametrize("others", [None, math.nan, 0.0])
def test_one_reading_is_enough(others):
    scan = scan_of(others)
    ranges = list(scan.ranges)
    ranges[7] = 1.0
    check_plausible(replace(scan, ranges=ranges), LAYERS, lambda: CORNER)


@pytest.mark.parametrize("pose", [Pose2D(-40.0, 2.0, 0.0), Pose2D(0.01, 0.01, 0.0)])
def test_pose_outside_the_map_or_in_a_wall_is_not_checked(pose):
    check_plausible(scan_of(None), LAYERS, lambda: pose)


def test_scan_without_ranges_is_not_checked():
    check_plausible(replace(scan_of(None), ranges=[]), LAYERS, lambda: CORNER)
