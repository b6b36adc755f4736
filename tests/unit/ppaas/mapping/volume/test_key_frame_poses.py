"""Poses of key frames: anchors of clouds, and motions since an earlier state."""

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.mapping.volume.key_frame_poses import NO_KEY_FRAMES, KeyFramePoses

BEFORE = KeyFramePoses(np.array([1.0, 2.0, 3.0]), np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]))


@pytest.mark.parametrize(("stamp", "anchor"), [(0.5, 1.0), (1.0, 1.0), (1.9, 1.0), (2.0, 2.0), (9.0, 3.0)])
def test_a_cloud_hangs_on_the_last_key_frame_before_it(stamp, anchor):
    assert BEFORE.anchor(stamp).stamp == anchor


def test_motion_is_that_of_the_key_frame_or_of_the_nearest_one_left():
    after = KeyFramePoses(np.array([1.0, 3.0, 4.0]), np.array([[0.0, 0.0, 0.0], [2.0, 1.0, 0.5], [3.0, 0.0, 0.0]]))
    assert after.differs(BEFORE)
    assert after.motion_since(BEFORE, 1.0) == Pose2D(0.0, 0.0, 0.0)
    for stamp in (2.5, 3.0):
        assert after.motion_since(BEFORE, stamp) @ Pose2D(2.0, 0.0, 0.0) == pytest.approx(Pose2D(2.0, 1.0, 0.5))


def test_a_key_frame_more_is_no_difference():
    after = KeyFramePoses(np.append(BEFORE.stamps, 4.0), np.vstack((BEFORE.poses, [[5.0, 5.0, 0.0]])))
    assert not after.differs(BEFORE)


def test_without_common_key_frames_nothing_moves():
    other = KeyFramePoses(BEFORE.stamps + 10.0, BEFORE.poses + 1.0)
    assert other.differs(BEFORE)
    assert other.motion_since(BEFORE, 2.0) == Pose2D(0.0, 0.0, 0.0)
    assert not len(NO_KEY_FRAMES)


@pytest.mark.parametrize(
    ("moved", "jumps"), [((0.4, 0.0, 0.1), False), ((0.6, 0.0, 0.0), True), ((0.0, 0.0, 0.4), True)]
)
def test_frame_has_jumped_if_the_last_key_frame_moved_far(moved, jumps):
    before = KeyFramePoses(np.array([1.0, 2.0]), np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]))
    motion = Pose2D(*moved)
    poses = np.array([motion @ Pose2D(*pose) for pose in before.poses.tolist()])
    after = KeyFramePoses(np.array([1.0, 2.0, 3.0]), np.vstack((poses, [[5.0, 0.0, 0.0]])))
    found = after.jump_since(before)
    assert (found is not None) is jumps
    if found is not None:
        np.testing.assert_allclose(found, motion, atol=1e-12)
    assert after.jump_since(NO_KEY_FRAMES) is None
    assert NO_KEY_FRAMES.jump_since(before) is None
