"""Beams of the laser of a map: which have readings, and which show free space."""

import math

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.mapping.parameters import SlamParameters
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.grid_slam.laser import MappingLaser
from ppaas.nodes.grid_slam.parameters import GridSlamParameters
from ppaas.nodes.grid_slam.scan_intake import blindness_status
from ppaas.nodes.robot_scans import RobotScan

RANGES: list[float | None] = [2.0, None, math.inf, math.nan, 8.0, 9.5, 6.5, 0.0, 0.02, -math.inf]


def scan_of(ranges: list[float | None]) -> LaserScan:
    return LaserScan(
        Header(frame_id="laser"), angle_min=-0.5, angle_max=0.4, angle_increment=0.1, range_min=0.05, range_max=8.0,
        ranges=ranges,
    )  # fmt: skip


def reaches(parameters: SlamParameters, *, frees: bool) -> tuple[list[float], list[bool]]:
    """Return the distances of the points of a scan [m], and which have a reading."""
    scan = RobotScan(scan_of(RANGES), Pose2D(0.0, 0.0, 0.0), 1.0, 1.0)
    found = MappingLaser.of(scan, parameters).points(scan, Pose2D(0.0, 0.0, 0.0), 1.0, frees=frees)
    return [round(float(each), 3) for each in np.hypot(*found.points.T)], found.valid.tolist()


def test_beams_that_hit_nothing_show_free_space_if_wanted() -> None:
    readings = [True, False, False, False, False, False, True, False, False, False]
    assert reaches(SlamParameters(), frees=False) == ([2.0, 0, 0, 0, 0, 0, 6.5, 0, 0, 0], readings)
    assert reaches(SlamParameters(), frees=True) == ([2.0, 8.0, 8.0, 8.0, 8.0, 8.0, 6.5, 0, 0, 0], readings)


def test_beams_are_free_up_to_the_largest_range_that_is_used() -> None:
    found, readings = reaches(SlamParameters(max_laser_range=6.0), frees=True)
    assert found == [2.0, 6.0, 6.0, 6.0, 6.0, 6.0, 6.0, 0, 0, 0]
    assert readings == [True] + [False] * 9


@pytest.mark.parametrize(
    ("parameters", "frees"),
    [({}, False), ({"inf_is_valid": True}, True), ({"maxUrange": 7.0}, True), ({"maxUrange": 8.0}, False),
     ({"max_laser_range": 7.0}, False)],
)  # fmt: skip
def test_beams_are_free_by_the_parameters_of_costmap_2d_and_gmapping(parameters: dict[str, float], frees: bool) -> None:
    assert GridSlamParameters(**parameters).frees(8.0) is frees


def test_a_scan_without_readings_is_explained_as_the_doctor_does() -> None:
    assert blindness_status(scan_of([2.0] * 10)) == ""
    text = blindness_status(scan_of([math.inf] * 10))
    assert text.startswith(
        "nothing is mapped: All ranges of the scans of 'laser' are null, NaN or infinite. See whether"
    )
    assert "set 'inf_is_valid' of grid_slam" in text
