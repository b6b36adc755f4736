"""Conversion of scans to points and beams."""

import math

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.localization.beams import MAX_RANGES, choose_beams, choose_rays, scan_points
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.sensor_msgs import LaserScan

HERE = Pose2D(0.0, 0.0, 0.0)


def scan(ranges, **fields):
    given = {"angle_min": 0.0, "angle_max": 3.0, "angle_increment": math.pi / 2, "range_min": 0.1, "range_max": 5.0}
    return LaserScan(Header(), ranges=ranges, **given | fields)


def test_scan_point_is_the_end_of_its_beam():
    np.testing.assert_allclose(scan_points(scan([1.0, 2.0, 3.0]), HERE), [[1, 0], [0, 2], [-3, 0]], atol=1e-12)


def test_scan_points_are_in_the_frame_of_the_laser_pose():
    points = scan_points(scan([1.0, 2.0]), Pose2D(10.0, 0.0, math.pi / 2))
    np.testing.assert_allclose(points, [[10, 1], [8, 0]], atol=1e-12)


def test_invalid_ranges_give_no_points():
    assert len(scan_points(scan([None, math.nan, math.inf, -math.inf, 0.05, 5.0, 7.0]), HERE)) == 0


@pytest.mark.parametrize("range_min", [0.0, -1.0])
def test_range_of_0_is_no_reading_whatever_range_min_is(range_min):
    zeros = scan([0.0, 2.0, 0.0], range_min=range_min)
    assert len(scan_points(zeros, HERE)) == 1
    assert len(choose_rays(zeros, HERE, 10)) == 1


def test_a_scan_without_ranges_gives_no_points():
    assert scan_points(scan([]), HERE).shape == (0, 2)


def test_chosen_beams_are_spread_evenly_over_the_points():
    points = np.stack((np.arange(50.0), np.zeros(50)), axis=1)
    np.testing.assert_allclose(choose_beams(points, 5)[:, 0], [0, 12, 24, 37, 49])


def test_few_points_are_all_chosen():
    points = np.array([[1.0, 0.0], [2.0, 0.0]])
    np.testing.assert_array_equal(choose_beams(points, 60), points)
    assert len(choose_beams(np.empty((0, 2)), 60)) == 0


def test_near_surfaces_count_by_length_and_not_by_beams():
    near = np.stack((np.full(300, 0.3), np.linspace(-0.3, 0.3, 300)), axis=1)
    far = np.stack((np.full(60, -5.0), np.linspace(-3.0, 3.0, 60)), axis=1)
    chosen = choose_beams(np.concatenate((near, far)), 60)
    assert (chosen[:, 0] > 0).sum() <= 8
    assert (chosen[:, 0] < 0).sum() >= 50


@pytest.mark.parametrize("name", ["angle_min", "angle_increment", "range_min", "range_max"])
def test_non_finite_limits_are_refused(name):
    with pytest.raises(InvalidInput, match="finite"):
        scan_points(scan([1.0], **{name: math.nan}), HERE)


def test_scan_with_too_many_ranges_is_refused():
    with pytest.raises(InvalidInput, match="at most"):
        scan_points(scan([1.0] * (MAX_RANGES + 1)), HERE)
