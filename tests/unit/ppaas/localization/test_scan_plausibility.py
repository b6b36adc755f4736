"""Plausibility check: a blind laser is told apart from one with nothing in reach."""

import math

import pytest
from msgspec.structs import replace

from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.localization.scan_match import check_plausible
from ppaas.messages.sensor_msgs import LaserScan
from tests.support.world.planar_world import World, walled_map

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
