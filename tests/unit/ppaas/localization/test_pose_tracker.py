"""Conditions under which scans are aligned, and what the tracker knows of the heading."""

import math

import numpy as np
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.pose_estimate import PoseEstimate
from ppaas.localization.pose_tracker import APART, LATE, MOVED, SOON, TURNED, UNKNOWN_HEADING, PoseTracker
from tests.support.world.planar_world import World, error_of, walled_map

GRID = walled_map(8.0, 6.0, [(3.0, 0.0, 3.4, 2.0), (6.0, 4.0, 7.0, 4.5)])
LAYERS = build_layers(GRID)
HERE = Pose2D(2.0, 3.0, 0.7)
ODOM = Pose2D(1.0, -1.0, 0.2)
DRIFT = AmclParameters().odom_drift


def seen_from(pose: Pose2D) -> np.ndarray:
    """Return the end points of a scan."""
    ranges = World(GRID, pose, beams=90).ranges()
    angles = np.linspace(-math.pi, math.pi, 90, endpoint=False)
    return np.column_stack((ranges * np.cos(angles), ranges * np.sin(angles)))


POINTS = seen_from(HERE)


def believed(pose: Pose2D = HERE, share: float = 1.0) -> PoseEstimate:
    return PoseEstimate(pose, np.diag((0.01, 0.01, 0.01)), share)


def tracker(now: float = 0.0) -> PoseTracker:
    """Return a tracker that has aligned a scan."""
    made = PoseTracker(LAYERS, AmclParameters())
    made.note_update(now)
    assert made.align(believed(), ODOM, POINTS, now) is not None
    return made


def test_the_pose_of_the_particles_is_corrected() -> None:
    made = PoseTracker(LAYERS, AmclParameters())
    found = made.align(believed(Pose2D(2.08, 2.95, 0.78)), ODOM, POINTS, 0.0)
    assert found is not None
    position, heading = error_of(found, HERE)
    assert position < 0.03 and heading < math.radians(1.0)


@pytest.mark.parametrize(
    ("odom", "after", "due"),
    [
        (ODOM, SOON, False),
        (ODOM, LATE, True),
        (ODOM @ Pose2D(1.1 * MOVED, 0.0), 0.9 * SOON, False),
        (ODOM @ Pose2D(1.1 * MOVED, 0.0), SOON, True),
        (ODOM @ Pose2D(0.0, 0.0, -1.1 * TURNED), SOON, True),
        (ODOM @ Pose2D(0.9 * MOVED, 0.0, 0.9 * TURNED), SOON, False),
    ],
)
def test_a_scan_is_aligned_if_odometry_has_moved_or_much_time_has_passed(odom: Pose2D, after: float, due: bool) -> None:
    assert tracker().due(odom, after) is due


def test_no_alignment_is_due_before_the_first_update() -> None:
    assert not PoseTracker(LAYERS, AmclParameters()).due(ODOM, 1e6)


def test_drift_of_the_heading_is_undone_by_each_alignment() -> None:
    made, odom = tracker(), ODOM
    for second in range(1, 200):
        odom = odom @ Pose2D(0.0, 0.0, DRIFT)
        found = made.align(believed(HERE @ ODOM.inverse() @ odom), odom, POINTS, float(second))
        assert found is None or error_of(found, HERE)[1] < math.radians(1.0)


def test_the_heading_gets_unsure_with_time_and_sure_by_an_alignment() -> None:
    made = tracker()
    sure = made.unsure(0.0)
    assert sure < math.radians(1.0)
    assert made.unsure(100.0) == pytest.approx(sure + 100.0 * DRIFT)
    assert made.unsure(1e6) == UNKNOWN_HEADING
    assert made.align(believed(), ODOM, POINTS, 100.0) is not None
    assert made.unsure(100.0) < math.radians(1.0)


def test_updates_of_particles_of_a_robot_that_drives_tell_the_heading() -> None:
    made = PoseTracker(LAYERS, AmclParameters())
    for second in range(100):
        made.note_update(float(second))
    assert made.unsure(99.0) == 0.0


def test_updates_of_particles_of_a_robot_that_stands_do_not_tell_the_heading() -> None:
    made = PoseTracker(LAYERS, AmclParameters())
    drifted = [made.note_update(50.0 * count) for count in range(5)]
    assert drifted == pytest.approx([0.0, *[50.0 * DRIFT] * 4])
    assert made.unsure(200.0) == pytest.approx(200.0 * DRIFT)


@pytest.mark.parametrize(
    ("points", "share"),
    [
        pytest.param(POINTS[:5], 1.0, id="few points"),
        pytest.param(0.4 * POINTS, 1.0, id="points that are not on the map"),
        pytest.param(POINTS, 0.6, id="particles at two places"),
    ],
)
def test_scans_that_do_not_tell_the_pose_are_not_used(points: np.ndarray, share: float) -> None:
    made = PoseTracker(LAYERS, AmclParameters())
    made.note_update(0.0)
    assert made.align(believed(share=share), ODOM, points, 0.0) is None
    assert made.unsure(100.0) == pytest.approx(100.0 * DRIFT)


def test_particles_elsewhere_are_believed() -> None:
    made, there = tracker(), Pose2D(6.5, 2.0, -1.0)
    assert there.distance_to(HERE) > APART
    found = made.align(believed(there), ODOM, seen_from(there), 0.2)
    assert found is not None and error_of(found, there)[0] < 0.05


def test_a_reset_of_the_odometry_is_no_motion() -> None:
    made, jump = tracker(), Pose2D(5.0, 2.0, 1.0)
    made.rebase(jump)
    odom = jump.inverse() @ ODOM
    assert not made.due(odom, SOON)
    found = made.align(believed(), odom, POINTS, 1.0)
    assert found is not None and error_of(found, HERE)[0] < 0.03
