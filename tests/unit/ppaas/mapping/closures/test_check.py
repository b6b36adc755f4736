import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.mapping.closures.check import ScanCheck, confirmed_share, weakest_information
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.key_frames import KeyFrames, NearFrames
from tests.support.world.room_scans import LASER, scan_at

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
    right, wrong = (confirmed_share(frames, 7, near, Pose2D(x, -1.0, 0.1), 0.3) for x in (POSES[7, 0], 1.0))
    assert right > 0.95
    assert wrong < 0.8


def test_scan_that_sees_nothing_in_common_confirms_nothing(frames):
    near = NearFrames(np.arange(6), POSES[:6])
    assert confirmed_share(frames, 7, near, Pose2D(500.0, 0.0, 0.0), 0.3) == 0.0


def test_weakest_information_is_the_smallest_eigenvalue():
    matrix = np.array([[5.0, 2.0], [2.0, 1.0]])
    given = np.array([5.0, 2.0, 9.0, 1.0, 9.0, 9.0])
    assert weakest_information(given) == pytest.approx(np.linalg.eigvalsh(matrix)[0])
