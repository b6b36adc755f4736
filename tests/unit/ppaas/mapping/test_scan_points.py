import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.scan_points import prepare, with_open_beams
from tests.support.world.room_scans import LASER, PARAMETERS, ROOM, ranges_at


def test_readings_are_finite_and_within_the_limits():
    ranges = np.full(181, 2.0)
    ranges[:6] = np.nan, np.inf, -1.0, 0.0, 0.04, 41.0
    scan = prepare(ranges, LASER, PARAMETERS)
    assert scan.valid.sum() == 175
    assert (scan.points[:6] == 0.0).all()
    np.testing.assert_allclose(np.hypot(*scan.points[6:].T), 2.0, rtol=1e-6)


def test_wrong_number_of_ranges_is_refused():
    with pytest.raises(InvalidInput, match="181 ranges, not 180"):
        prepare(np.ones(180), LASER, PARAMETERS)


def test_scan_of_a_moving_laser_is_corrected_by_its_velocity():
    slow = LaserGeometry(LASER.angle_min, LASER.angle_increment, 181, time_increment=1e-3, stamped_at=0.0)
    speed, turn = 1.0, 0.8
    ranges = np.empty(181)
    for b in range(181):
        late = b * 1e-3
        pose = (speed / turn * np.sin(turn * late), speed / turn * (1.0 - np.cos(turn * late)), turn * late)
        ranges[b] = ranges_at(pose, LASER, ROOM)[b]
    corrected = prepare(ranges, slow, PARAMETERS, (speed, 0.0, turn))
    plain = prepare(ranges, slow, PARAMETERS)
    ahead = (np.abs(corrected.points[:, 1]) < 0.5) & (corrected.points[:, 0] > 3.0)
    assert np.abs(corrected.points[ahead, 0] - 4.0).max() < 0.02
    assert np.abs(plain.points[ahead, 0] - 4.0).max() > 0.05


def test_beams_that_hit_nothing_are_free_up_to_a_range():
    ranges = np.full(181, 2.0)
    ranges[50:60] = np.nan
    scan = prepare(ranges, LASER, PARAMETERS)
    hit_nothing = np.zeros(181, bool)
    hit_nothing[40:55] = True
    found = with_open_beams(scan, hit_nothing, 8.0, LASER)
    assert not found.valid[50:60].any()
    np.testing.assert_array_equal(found.points[:50], scan.points[:50])
    np.testing.assert_allclose(np.hypot(*found.points[50:55].T), 8.0, rtol=1e-6)
    bearings = LASER.angle_min + LASER.angle_increment * np.arange(50, 55)
    np.testing.assert_allclose(np.arctan2(*found.points[50:55, ::-1].T), bearings, rtol=1e-5)
    assert (found.points[55:60] == 0.0).all()


def test_free_beams_of_a_moving_laser_are_where_those_with_readings_would_be():
    slow = LaserGeometry(LASER.angle_min, LASER.angle_increment, 181, time_increment=1e-3, stamped_at=0.3)
    velocity = (1.0, 0.2, 0.8)
    measured = prepare(np.full(181, 8.0), slow, PARAMETERS, velocity)
    none = prepare(np.full(181, np.nan), slow, PARAMETERS, velocity)
    found = with_open_beams(none, np.ones(181, bool), 8.0, slow, velocity)
    np.testing.assert_allclose(found.points, measured.points, atol=1e-5)
