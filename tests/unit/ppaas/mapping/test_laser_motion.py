import math

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.laser_motion import MOST, laser_step, odometry_deviations, velocities, velocity
from ppaas.mapping.parameters import SlamParameters

MOUNT = Pose2D(0.3, 0.1, 0.5)


def test_step_of_the_laser_moves_its_pose():
    before, after = Pose2D(1.0, 2.0, 0.4), Pose2D(1.2, 2.1, 0.9)
    assert before @ MOUNT @ laser_step(before, after, MOUNT) == pytest.approx(after @ MOUNT)


def test_velocity_is_the_step_per_second_in_the_frame_after_it_within_limits():
    np.testing.assert_allclose(velocity(Pose2D(0.1, 0.0, 0.0), 0.5), (0.2, 0.0, 0.0))
    np.testing.assert_allclose(velocity(Pose2D(0.0, 0.1, np.pi / 2.0), 1.0), (0.1, 0.0, np.pi / 2.0), atol=1e-12)
    np.testing.assert_allclose(velocity(Pose2D(9.0, -9.0, 0.0), 0.0), (3.0, -3.0, 0.0))


def test_velocities_are_those_of_a_turn_about_the_robot_in_any_order_of_the_log():
    times = np.arange(10) * 0.1
    odometry = np.column_stack((0.2 * times, 0.0 * times, np.zeros(10)))
    odometry[:, 2] = 0.5 * times
    order = np.random.default_rng(0).permutation(10)
    found = velocities(times[order], odometry[order], Pose2D(0.4, 0.0, 0.0))
    inner = (order > 0) & (order < 9)
    assert (found[~inner] == 0.0).all()
    np.testing.assert_allclose(found[inner, 2], 0.5)
    forward = 0.2 * np.cos(odometry[order[inner], 2])
    left = -0.2 * np.sin(odometry[order[inner], 2]) + 0.5 * 0.4
    np.testing.assert_allclose(found[inner, :2], np.column_stack((forward, left)), atol=5e-3)


def test_jumps_of_the_odometry_are_limited_and_short_logs_stand_still():
    jump = velocities([0.0, 0.1, 0.2], [(0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (50.0, 0.0, 0.0)], MOUNT)
    assert (np.abs(jump) <= MOST).all()
    assert (velocities([0.0, 0.1], np.eye(3)[:2], MOUNT) == 0.0).all()


def test_beams_per_turn_are_those_of_a_full_circle():
    assert LaserGeometry(-math.pi / 2.0, math.pi / 180.0, 181).beams_per_turn == 360
    clockwise = LaserGeometry(math.pi, -math.radians(0.5), 721)
    assert (clockwise.beams_per_turn, clockwise.beams_per_radian) == (720, pytest.approx(-360.0 / math.pi))


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ((math.nan, 0.01, 10), "finite"),
        ((0.0, 0.01, 10, Pose2D(math.inf, 0.0, 0.0)), "finite"),
        ((0.0, 0.01, 0), "beams"),
        ((0.0, 1e-4, 10_001), "beams"),
        ((0.0, 0.0, 10), "at most one turn"),
        ((0.0, 0.01, 700), "at most one turn"),
        ((0.0, 0.01, 10, Pose2D(0.0, 0.0, 0.0), -1e-3), "time_increment"),
        ((0.0, 0.01, 10, Pose2D(0.0, 0.0, 0.0), 0.0, 1.5), "stamped_at"),
    ],
)
def test_invalid_geometry_is_refused(arguments, text):
    with pytest.raises(InvalidInput, match=text):
        LaserGeometry(*arguments)


def test_noise_grows_with_distance_and_turn():
    parameters = SlamParameters(
        srr=0.1, srt=0.2, str=0.3, stt=0.4, odometry_deviation=0.01, odometry_heading_deviation=0.02
    )
    assert odometry_deviations(Pose2D(0.0, 0.0, 0.0), parameters) == pytest.approx((0.01, 0.01, 0.02))
    found = odometry_deviations(Pose2D(0.3, -0.4, -1.0), parameters)
    assert found == pytest.approx((0.01 + 0.05 + 0.2, 0.01 + 0.05 + 0.2, 0.02 + 0.15 + 0.4))
