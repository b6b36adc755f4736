"""Distance sensors as laser scans."""

import math
from typing import Any

import pytest

from ppaas.messages.base.std_msgs import Time
from robots.bridges.mavlink.dialect import mavlink
from robots.bridges.mavlink.proximity import UNKNOWN, Proximity, ring

NOW = Time(5, 0)


def obstacles(distances: list[int], *, step: int = 0, step_f: float = 0.0, offset: float = 0.0, frame: int = 12) -> Any:
    full = [*distances, *[UNKNOWN] * (72 - len(distances))]
    return mavlink.MAVLink_obstacle_distance_message(0, 0, full, step, 20, 1200, step_f, offset, frame)


def beams(scan: Any) -> dict[int, float | None]:
    """Return the ranges by their angles [°]."""
    return {
        round(math.degrees(scan.angle_min + number * scan.angle_increment)) % 360: distance
        for number, distance in enumerate(scan.ranges)
    }


@pytest.mark.parametrize("steps", [{"step": 5}, {"step_f": 5.0}, {"step": 7, "step_f": 5.0}])
def test_a_ring_clockwise_from_ahead_is_a_scan_counter_clockwise(steps: dict[str, Any]) -> None:
    distances = [1201] * 72
    distances[0], distances[18], distances[1] = 300, 150, UNKNOWN  # ahead, to the right, not known
    scan = ring(obstacles(distances, **steps), NOW)
    assert scan is not None
    found = beams(scan)
    assert len(found) == 72
    assert (found[0], found[270], found[355], found[90]) == (3.0, 1.5, None, 12.01)
    assert (scan.range_min, scan.range_max) == (0.2, 12.0)
    assert scan.angle_max - scan.angle_min == pytest.approx(math.radians(355.0))
    assert scan.header.frame_id == "base_link" and scan.header.stamp == NOW


def test_a_ring_may_begin_elsewhere_and_go_round_the_other_way() -> None:
    half = ring(obstacles([100, 200, 300], step_f=30.0, offset=-30.0), NOW)
    assert half is not None
    assert beams(half) | {30: 1.0, 0: 2.0, 330: 3.0} == beams(half)
    other = ring(obstacles([100, 200, 300], step_f=-30.0, offset=-30.0), NOW)
    assert other is not None
    assert beams(other) | {30: 1.0, 60: 2.0, 90: 3.0} == beams(other)


def test_rings_that_say_nothing_are_left_out() -> None:
    assert ring(obstacles([100]), NOW) is None, "its sectors have no width"
    assert ring(obstacles([100], step=5, frame=mavlink.MAV_FRAME_LOCAL_NED), NOW) is None
    assert ring(obstacles([100], step_f=1000.0), NOW) is None
    assert ring(obstacles([100], step_f=math.nan), NOW) is None


def sensor(orientation: int, distance: int, most: int = 800) -> Any:
    return mavlink.MAVLink_distance_sensor_message(0, 10, most, distance, 0, orientation, orientation, 0)


def test_single_sensors_are_one_scan_a_round() -> None:
    proximity = Proximity()
    proximity.take(sensor(0, 300), 0.0, NOW)
    scan = proximity.take(sensor(2, 150), 0.0, NOW)  # to the right
    assert scan is not None and beams(scan)[270] == 1.5
    scan = proximity.take(sensor(0, 310), 0.1, NOW)
    assert scan is not None
    assert beams(scan) == {0: 3.1, 45: None, 90: None, 135: None, 180: None, 225: None, 270: 1.5, 315: None}
    assert proximity.take(sensor(2, 140), 0.1, NOW) is None
    scan = proximity.take(sensor(0, 320), 2.0, NOW)
    assert scan is not None and beams(scan)[270] is None, "it is old"
    assert proximity.take(sensor(25, 20), 2.0, NOW) is None, "it looks down"


def test_a_ring_is_believed_before_single_sensors() -> None:
    proximity = Proximity()
    assert proximity.take(obstacles([300], step=5), 0.0, NOW) is not None
    assert proximity.take(sensor(0, 100), 0.5, NOW) is None
    assert proximity.take(sensor(0, 100), 1.5, NOW) is not None
