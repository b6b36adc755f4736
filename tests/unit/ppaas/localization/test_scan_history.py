"""History of the scans of the last metres."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.localization.relocalization import SCANS, SPACING, SPACING_TURN, ScanHistory

POINT = np.array([[1.0, 0.0]])
numbers = st.floats(-3.0, 3.0)
poses = st.builds(Pose2D, numbers, numbers, numbers)


def test_scan_is_stored_only_after_the_robot_has_moved() -> None:
    history = ScanHistory()
    assert history.note(Pose2D(0.0, 0.0, 0.0), POINT)
    assert not history.note(Pose2D(0.9 * SPACING, 0.0, 0.9 * SPACING_TURN), POINT)
    assert history.note(Pose2D(0.0, 0.0, 1.1 * SPACING_TURN), POINT)
    assert history.note(Pose2D(1.1 * SPACING, 0.0, 1.1 * SPACING_TURN), POINT)
    assert history.metres == pytest.approx(1.1 * SPACING)


@given(st.lists(poses, min_size=1, max_size=6))
def test_points_of_all_scans_agree_in_the_newest_frame(odoms: list[Pose2D]) -> None:
    wall = Pose2D(5.0, -2.0, 0.0)
    history, last = ScanHistory(), odoms[0]
    for odom in odoms:
        x, y, _ = odom.inverse() @ wall
        if history.note(odom, np.array([[x, y]])):
            last = odom
    x, y, _ = last.inverse() @ wall
    seen = history.seen()
    np.testing.assert_allclose(seen[:, :2], np.tile((x, y), (len(seen), 1)), atol=1e-9)
    # Each ray keeps its length, and those of the newest scan start at the robot.
    origins = [last.inverse() @ odom for odom in odoms]
    assert all(min(math.dist(row, origin[:2]) for origin in origins) < 1e-9 for row in seen[:, 2:].tolist())
    np.testing.assert_allclose(seen[-1, 2:], 0.0, atol=1e-12)


def test_oldest_scan_is_dropped() -> None:
    history = ScanHistory()
    for i in range(SCANS + 3):
        assert history.full == (i >= SCANS)
        history.note(Pose2D(i, 0.0, 0.0), POINT)
    assert len(history.seen()) == SCANS
    assert history.metres == SCANS - 1


def test_rebase_keeps_the_history_after_an_odometry_reset() -> None:
    history, jump = ScanHistory(), Pose2D(3.0, -1.0, math.pi / 3)
    history.note(Pose2D(0.0, 0.0, 0.0), POINT)
    history.note(Pose2D(1.0, 0.0, 0.0), POINT)
    before = history.seen()
    history.rebase(jump)
    assert not history.note(jump.inverse() @ Pose2D(1.1, 0.0, 0.0), POINT)
    np.testing.assert_allclose(history.seen(), before, atol=1e-12)
