"""Facts of scans, and how much of a scan a map explains."""

import math

import msgspec
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.diagnosis.observations.scans import explained, scan_facts
from ppaas.geometry import Pose2D
from tests.support.world.diagnosed_robot import DiagnosedRobot
from tests.support.world.planar_world import walled_map

ROBOT = DiagnosedRobot()


def test_shares_of_the_ranges_of_a_scan() -> None:
    scan = ROBOT.scan(ranges=[1.0, 2.0, 0.0, None, math.inf, math.nan, 0.05, 9.0], angle_max=math.nan)
    facts = scan_facts(scan)
    shares = (facts.readings, facts.zeros, facts.empty, facts.short)
    assert shares == (2 / 8, 1 / 8, 3 / 8, 1 / 8)
    assert (facts.frame, facts.beams, facts.excess, facts.intensities) == ("base_scan", 8, 0.0, 0)


def test_scan_without_ranges_has_facts() -> None:
    facts = scan_facts(ROBOT.scan(ranges=[]))
    assert (facts.beams, facts.readings) == (0, 0.0)


def test_map_explains_a_scan_from_the_right_place_only() -> None:
    layers = build_layers(walled_map(4, 4, []))
    scan = ROBOT.scan()
    step = scan.angle_increment
    square = [1.9 / max(abs(math.cos(-math.pi + i * step)), abs(math.sin(-math.pi + i * step))) for i in range(180)]
    seen = msgspec.structs.replace(scan, ranges=square)
    right, wrong = (explained(seen, Pose2D(x, 2.0, 0.0), layers) for x in (2.0, 20.0))
    assert right is not None
    assert right > 0.9
    assert wrong == 0.0


@pytest.mark.parametrize("changed", [{"ranges": [1.0] * 5}, {"angle_min": math.nan}, {"range_max": 0.0}])
def test_nothing_is_said_of_a_scan_with_few_readings_or_invalid_angles(changed: dict[str, object]) -> None:
    layers = build_layers(walled_map(4, 4, []))
    assert explained(ROBOT.scan(**changed), Pose2D(2.0, 2.0, 0.0), layers) is None
