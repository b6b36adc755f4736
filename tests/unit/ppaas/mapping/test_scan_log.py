"""Logs of scans whose beams differ."""

import math

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.mapping.scan_log import LoggedScan, joined

STEP = math.radians(1.0)
MOUNT = Pose2D(0.1, 0.0)


def scan(count: int, first: float = -0.5, step: float = STEP) -> LoggedScan:
    return LoggedScan(np.arange(1.0, count + 1.0, dtype=np.float32), first, step)


def log_of(*scans: LoggedScan):
    return joined(list(range(len(scans))), [Pose2D(float(i), 0.0) for i in range(len(scans))], scans, MOUNT)


def test_equal_scans_share_their_geometry():
    log = log_of(scan(5), scan(5))
    assert len(log) == 2
    assert log.geometry_of(1) is log.geometry
    assert (log.geometry.angle_min, log.geometry.beams, log.geometry.mount) == (-0.5, 5, MOUNT)
    np.testing.assert_array_equal(log.ranges, [[1, 2, 3, 4, 5]] * 2)
    np.testing.assert_array_equal(log.odometry, [(0, 0, 0), (1, 0, 0)])


def test_interleaved_scans_keep_their_own_first_angle():
    log = log_of(scan(5), scan(5), scan(4, -0.5 + 0.25 * STEP))
    assert log.geometry_of(2).angle_min == pytest.approx(-0.5 + 0.25 * STEP)
    np.testing.assert_array_equal(log.ranges[2], [1, 2, 3, 4, np.nan])
    assert log.skipped == 0


@pytest.mark.parametrize(
    ("shift", "count", "expected"),
    [(2, 3, [np.nan, np.nan, 1, 2, 3]), (-1, 5, [2, 3, 4, 5, np.nan]), (-1, 7, [2, 3, 4, 5, 6])],
)
def test_scans_with_other_beam_counts_are_shifted_by_whole_beams(shift, count, expected):
    log = log_of(scan(5), scan(5), scan(count, -0.5 + shift * STEP))
    np.testing.assert_array_equal(log.ranges[2], expected)
    assert log.first_angles[2] == pytest.approx(-0.5)


def test_scans_of_another_laser_have_no_ranges_and_are_counted():
    log = log_of(scan(5), scan(5), scan(5, step=2.0 * STEP), scan(3, first=2.0))
    assert np.isnan(log.ranges[2:]).all()
    assert log.skipped == 2


def test_the_first_scans_can_be_taken():
    log = log_of(scan(5), scan(5), scan(5)).first(2)
    assert (len(log), log.ranges.shape, log.odometry.shape) == (2, (2, 5), (2, 3))


def test_no_scans_are_refused():
    with pytest.raises(InvalidInput, match="no scan"):
        log_of()
