import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.mapping.closures.check import ScanCheck
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.key_frame_graph import weakest_information
from ppaas.mapping.key_frames import KeyFrames, NearFrames
from ppaas.mapping.visible_points import confirmed_share
from ppaas.planar_poses import relative
from tests.support.world.room_scans import CORRIDOR, LASER, scan_at

TARGET = Submap(0, 6)
SOURCE = Submap(6, 11)
POSES = np.array([(-2.0 + 0.25 * (k % 6), -1.0, 0.1) for k in range(11)])


@pytest.fixture(scope="module")
def frames():
    frames = KeyFrames(LASER)
    for k, pose in enumerate(POSES):
        frames.add(scan_at(pose), k, Pose2D(*pose.tolist()), np.zeros(6))
    return frames


def test_all_scans_of_a_right_match_pass(frames):
    passed = ScanCheck(frames, POSES, ClosureParameters()).run(SOURCE, TARGET, POSES[6:])
    assert [scan.source for scan in passed] == [6, 7, 8, 9, 10]
    assert all(scan.confirmed > 0.95 for scan in passed)


def test_no_scan_of_a_wrong_match_passes(frames):
    moved = POSES[6:] + np.array([1.5, 0.0, 0.0])
    assert ScanCheck(frames, POSES, ClosureParameters()).run(SOURCE, TARGET, moved) == []


def test_scan_in_another_place_is_contradicted(frames):
    near = NearFrames(np.arange(6), POSES[:6])
    scan = frames.scan_points(7)
    right, wrong = (confirmed_share(frames, scan, near, Pose2D(x, -1.0, 0.1), 0.3) for x in (POSES[7, 0], 1.0))
    assert right > 0.95
    assert wrong < 0.8


def test_scan_that_sees_nothing_in_common_confirms_nothing(frames):
    near = NearFrames(np.arange(6), POSES[:6])
    assert confirmed_share(frames, frames.scan_points(7), near, Pose2D(500.0, 0.0, 0.0), 0.3) == 0.0


def test_scans_in_opposite_directions_are_aligned_with_those_that_show_the_same():
    there = np.stack((np.arange(0.0, 10.0, 0.25), np.zeros(40), np.zeros(40)), axis=1)
    poses, both = np.concatenate((there, there[30:35] + np.array((0.0, 0.0, np.pi)))), KeyFrames(LASER)
    for k, pose in enumerate(poses):
        both.add(scan_at(pose, walls=CORRIDOR), k, Pose2D(*pose.tolist()), np.zeros(6))
    check = ScanCheck(both, poses, ClosureParameters())
    passed = check.run(Submap(40, 45), Submap(0, 40), poses[40:], slides=True)
    assert len(passed) == 5
    for scan in passed:
        assert poses[scan.target, 0] < poses[scan.source, 0] - 2.0
        np.testing.assert_allclose(scan.measurement, relative(poses[scan.target], poses[scan.source]), atol=0.01)


def test_scans_along_a_bare_corridor_say_nothing_of_the_position_along_it():
    poses, corridor = np.stack((np.arange(0.0, 4.0, 0.25), np.zeros(16), np.zeros(16)), axis=1), KeyFrames(LASER)
    for k, pose in enumerate(poses):
        corridor.add(scan_at(pose, walls=CORRIDOR), k, Pose2D(*pose.tolist()), np.zeros(6))
    check, parts = ScanCheck(corridor, poses, ClosureParameters()), (Submap(8, 16), Submap(0, 8))
    assert check.run(*parts, poses[8:]) == []
    passed = check.run(*parts, poses[8:], slides=True)
    assert len(passed) == 5
    for scan in passed:
        assert weakest_information(scan.information) < 1e-6
        assert scan.information[3] > 1e4  # across
        assert scan.information[5] > 1e4  # heading
