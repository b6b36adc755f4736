"""Scans without what the robot carries."""

import math

import numpy as np
import pytest

from ppaas.messages.base.std_msgs import Header
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.perception.carried_load import MARGIN, LoadFilter
from ppaas.transforms.spatial import Rigid

SQUARE = ((0.4, 0.4), (-0.4, 0.4), (-0.4, -0.4), (0.4, -0.4))


def scan_of(ranges: list[float | None]) -> LaserScan:
    step = 2.0 * math.pi / len(ranges)
    return LaserScan(Header(), 0.0, 2.0 * math.pi - step, step, 0.05, 8.0, ranges)


@pytest.mark.parametrize("mount", [Rigid(), Rigid(0.1, -0.2), Rigid(0.1, -0.2, 0.3, qx=1.0, qw=0.0)])
def test_exactly_readings_in_the_load_are_removed(mount: Rigid) -> None:
    rng = np.random.default_rng(3)
    ranges = rng.uniform(0.06, 1.2, 90).tolist()
    found = LoadFilter(SQUARE).without_load(scan_of(ranges), mount)
    side = -1.0 if mount.qx else 1.0
    for number, (before, after) in enumerate(zip(ranges, found.ranges, strict=True)):
        angle = 2.0 * math.pi * number / 90
        x, y = mount.x + before * math.cos(angle), mount.y + side * before * math.sin(angle)
        inside = max(abs(x), abs(y)) <= 0.4 + MARGIN
        assert after is not None and math.isnan(after) == inside
        assert inside or after == before


def test_a_scan_that_shows_no_load_is_the_same_object() -> None:
    scan = scan_of([2.0, None, math.inf, math.nan, 0.7])
    assert LoadFilter(SQUARE).without_load(scan, Rigid()) is scan
