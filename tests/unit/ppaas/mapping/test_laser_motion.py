import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.mapping.laser_motion import MOST, laser_step, velocities, velocity

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
