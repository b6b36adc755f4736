import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.scan_points import prepare
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
