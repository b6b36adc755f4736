import pytest

from ppaas.geometry import Pose2D
from ppaas.mapping.laser_motion import odometry_deviations
from ppaas.mapping.parameters import SlamParameters


def test_noise_grows_with_distance_and_turn():
    parameters = SlamParameters(
        srr=0.1, srt=0.2, str=0.3, stt=0.4, odometry_deviation=0.01, odometry_heading_deviation=0.02
    )
    assert odometry_deviations(Pose2D(0.0, 0.0, 0.0), parameters) == pytest.approx((0.01, 0.01, 0.02))
    found = odometry_deviations(Pose2D(0.3, -0.4, -1.0), parameters)
    assert found == pytest.approx((0.01 + 0.05 + 0.2, 0.01 + 0.05 + 0.2, 0.02 + 0.15 + 0.4))
