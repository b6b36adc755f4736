import math

import numpy as np
import pytest

from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D
from robots.sim.odometry import OdometryNoise, WheelOdometry

DT = 0.02


def run(drift: float, seed: int) -> Pose2D:
    """Drive a square of 5 m twice, back to the start; return the pose of the odometry."""
    odometry = WheelOdometry(OdometryNoise(drift=drift), np.random.default_rng(seed))
    for _ in range(8):
        for _ in range(500):
            odometry.update(0.5, 0.0, DT)
        for _ in range(100):
            odometry.update(0.0, math.pi / 4, DT)
    return odometry.pose


def test_odometry_without_drift_returns_to_the_start() -> None:
    assert run(0.0, 1) == pytest.approx(Pose2D(0.0, 0.0, 0.0), abs=1e-9)


def test_odometry_starts_at_its_own_origin() -> None:
    odometry = WheelOdometry(OdometryNoise(), np.random.default_rng(1))
    message = odometry.message(5.0, "odom", "base_link")
    assert message.pose.pose.planar() == Pose2D(0.0, 0.0, 0.0)
    assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_link")


def test_the_error_grows_linearly_with_the_drift() -> None:
    seeds = range(40)
    once, thrice = (np.mean([run(drift, seed).distance_to(Pose2D(0.0, 0.0)) for seed in seeds]) for drift in (1.0, 3.0))
    assert 0.1 < once < 1.5
    assert 2.5 < thrice / once < 3.5


def test_a_slow_curve_is_integrated_as_an_arc() -> None:
    odometry = WheelOdometry(OdometryNoise(drift=0.0), np.random.default_rng(1))
    for _ in range(round(math.pi / 0.5 / DT)):
        odometry.update(0.5, 0.5, DT)
    assert odometry.pose.x == pytest.approx(0.0, abs=0.02)
    assert odometry.pose.y == pytest.approx(2.0, abs=0.001)


def test_the_reported_velocity_is_near_the_true_one() -> None:
    odometry = WheelOdometry(OdometryNoise(), np.random.default_rng(1))
    odometry.update(0.4, -0.3, DT)
    twist = odometry.message(0.0, "odom", "base_link").twist.twist
    assert (twist.linear.x, twist.angular.z) == pytest.approx((0.4, -0.3), rel=0.05)


@pytest.mark.parametrize("drift", [-1.0, math.nan, math.inf])
def test_an_invalid_drift_is_refused(drift: float) -> None:
    with pytest.raises(InvalidParameter, match="drift"):
        OdometryNoise(drift=drift)


def test_wheels_and_gyro_have_separate_scales() -> None:
    model = OdometryNoise(scale=0.0, gyro_scale=0.2, gyro_bias=0.0, gyro_walk=0.0, noise_linear=0.0, noise_angular=0.0)
    odometry = WheelOdometry(model, np.random.default_rng(1))
    odometry.update(1.0, 1.0, DT)
    assert odometry.velocity.linear == 1.0
    assert odometry.velocity.angular != 1.0
