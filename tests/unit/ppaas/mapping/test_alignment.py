import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.mapping.alignment import CHECKING, Prior, align
from ppaas.mapping.key_frames import KeyFrames, NearFrames
from ppaas.planar_poses import symmetric
from tests.support.world.room_scans import ALL_ROUND, CORRIDOR, LASER, ROOM, scan_at

POSES = np.array([(0.0, 0.0, 0.0), (0.3, 0.1, 0.1), (-0.2, 0.2, -0.1)])


def frames_at(poses, laser=LASER, walls=ROOM):
    frames = KeyFrames(laser)
    for number, pose in enumerate(poses):
        frames.add(scan_at(pose, laser, walls, 0.005, number), number, Pose2D(*pose), np.zeros(6))
    return frames


@pytest.mark.parametrize("laser", [LASER, ALL_ROUND])
@given(st.integers(0, 2**32 - 1))
def test_scan_is_aligned_to_millimetres(laser, seed):
    frames = frames_at(POSES, laser)
    rng = np.random.default_rng(seed)
    true = rng.uniform((-0.3, -0.3, -0.3), (0.3, 0.3, 0.3))
    start = true + rng.uniform((-0.15, -0.15, -0.1), (0.15, 0.15, 0.1))
    aligned = align(scan_at(true, laser, noise=0.005, seed=seed), Pose2D(*start), frames, frames.latest(3))
    assert np.abs(np.array(aligned.pose) - true).max() < 0.01
    assert aligned.ratio > 0.7
    assert aligned.pairs > 1.5 * laser.beams


def test_poses_of_key_frames_are_those_given():
    frames = frames_at(POSES)
    moved = Pose2D(5.0, -3.0, 2.0)
    near = NearFrames(np.array([2, 0]), np.array([moved @ Pose2D(*POSES[2]), moved @ Pose2D(*POSES[0])]))
    aligned = align(scan_at((0.1, 0.1, 0.05)), moved @ Pose2D(0.15, 0.1, 0.02), frames, near)
    assert aligned.pose == pytest.approx(moved @ Pose2D(0.1, 0.1, 0.05), abs=0.01)


def test_corridor_is_not_determined_along_its_axis_and_the_prior_decides():
    frames = frames_at([(0.0, 0.0, 0.0)], walls=CORRIDOR)
    scan = scan_at((0.5, 0.2, 0.0), walls=CORRIDOR)
    free = align(scan, Pose2D(0.3, 0.15, 0.02), frames, frames.latest(1))
    assert free.pose.x == pytest.approx(0.3, abs=0.02)
    assert free.pose.y == pytest.approx(0.2, abs=0.01)
    deviations = np.sqrt(np.diag(np.linalg.inv(symmetric(free.information))))
    assert deviations[0] > 30.0 * deviations[1]
    prior = Prior(Pose2D(0.6, 0.1, 0.0), (0.01, 0.1, 0.1))
    held = align(scan, Pose2D(0.3, 0.15, 0.02), frames, frames.latest(1), prior=prior)
    assert held.pose == pytest.approx((0.6, 0.2, 0.0), abs=0.01)


def test_information_of_the_prior_is_added():
    frames = frames_at(POSES)
    start, scan = Pose2D(0.0, 0.0, 0.0), scan_at((0.0, 0.0, 0.0))
    without = align(scan, start, frames, frames.latest(3))
    prior = align(scan, start, frames, frames.latest(3), prior=Prior(start, (0.1, 0.2, 0.5)))
    added = prior.information - without.information
    np.testing.assert_allclose(added[[0, 3, 5]], (100.0, 25.0, 4.0), atol=0.02 * without.information.max())


def test_pose_stays_without_key_frames_or_readings():
    frames, start = frames_at(POSES), Pose2D(0.1, -0.2, 0.3)
    empty = scan_at((0.0, 0.0, 0.0))._replace(valid=np.zeros(181, np.bool_))
    for scan, near in ((empty, frames.latest(3)), (scan_at((0.0, 0.0, 0.0)), frames.latest(0))):
        aligned = align(scan, start, frames, near, CHECKING)
        assert aligned.pose == pytest.approx(start)
        assert (aligned.ratio, aligned.pairs) == (0.0, 0)
