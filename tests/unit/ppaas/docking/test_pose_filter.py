"""Filter of the poses of a dock."""

import numpy as np
import pytest

from ppaas.docking.pose_filter import DOUBTS, ENOUGH, DockPoseFilter
from ppaas.geometry import Pose2D


def test_a_pose_is_known_once_some_agree() -> None:
    found = DockPoseFilter()
    for count in range(1, ENOUGH + 1):
        assert found.pose is None
        found.take(Pose2D(1.0, 2.0, 3.1), float(count))
    assert found.pose == pytest.approx((1.0, 2.0, 3.1))
    assert found.seen_at == ENOUGH


def test_noise_is_smoothed_across_half_a_turn() -> None:
    rng, found = np.random.default_rng(0), DockPoseFilter()
    for now in range(100):
        x, y, theta = rng.normal((1.0, 2.0, np.pi), (0.02, 0.02, 0.05)).tolist()
        found.take(Pose2D(x, y, theta), float(now))
    assert found.pose is not None
    assert found.pose.distance_to(Pose2D(1.0, 2.0)) < 0.02
    assert abs(abs(found.pose.theta) - np.pi) < 0.05


def test_single_wrong_poses_change_nothing_and_a_moved_dock_is_followed() -> None:
    found = DockPoseFilter()
    for now in range(5):
        found.take(Pose2D(1.0, 0.0), float(now))
    for wrong in (Pose2D(1.4, 0.0), Pose2D(1.0, 0.5), Pose2D(1.0, 0.0, 1.5)):
        found.take(wrong, 6.0)
    assert found.pose == pytest.approx((1.0, 0.0, 0.0))
    assert found.seen_at == 4.0
    for _ in range(DOUBTS):
        found.take(Pose2D(1.2, 0.0), 7.0)
    assert found.pose == pytest.approx((1.2, 0.0, 0.0))
