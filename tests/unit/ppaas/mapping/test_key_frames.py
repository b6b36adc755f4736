import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from ppaas.errors import QuotaExceeded
from ppaas.geometry import Pose2D
from ppaas.mapping import near_poses
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.near_poses import nearest_poses
from tests.support.world.room_scans import LASER, scan_at

SCAN = scan_at((0.0, 0.0, 0.0))


def add(frames, count):
    for k in range(count):
        frames.add(SCAN, 3 * k, Pose2D(0.1 * k, 0.0, 0.0), np.full(6, float(k)))


def test_frames_stay_when_the_arrays_grow():
    frames = KeyFrames(LASER)
    add(frames, 200)
    assert len(frames) == 200
    np.testing.assert_array_equal(frames.scans, 3 * np.arange(200))
    np.testing.assert_allclose(frames.poses[:, 0], 0.1 * np.arange(200))
    np.testing.assert_array_equal(frames.information[:, 5], np.arange(200))
    for stored, expected in zip(frames.scan_points(150), SCAN, strict=True):
        np.testing.assert_array_equal(stored, expected)
    assert frames.points.shape == frames.normals.shape == (200, 181, 2)
    assert frames.valid.shape == (200, 181)


def test_latest_frames_are_the_last_ones_at_the_poses_stored():
    frames = KeyFrames(LASER)
    assert frames.latest(3).poses.shape == (0, 3)
    add(frames, 5)
    np.testing.assert_array_equal(frames.latest(3).indices, (2, 3, 4))
    np.testing.assert_array_equal(frames.latest(9).indices, np.arange(5))
    frames.poses[4] = (1.0, 2.0, 3.0)
    np.testing.assert_array_equal(frames.latest(1).poses, [(1.0, 2.0, 3.0)])


def test_number_of_frames_is_limited():
    frames = KeyFrames(LASER, 70)
    add(frames, 70)
    with pytest.raises(QuotaExceeded, match="70 key frames"):
        add(frames, 1)
    assert len(frames) == 70


def test_snapshot_at_other_poses_leaves_the_frames_where_they_are():
    frames, poses = KeyFrames(LASER), np.arange(15.0).reshape(5, 3)
    add(frames, 5)
    moved = frames.at(poses)
    poses[0] = 9.0
    np.testing.assert_array_equal(moved.poses, np.arange(15.0).reshape(5, 3))
    np.testing.assert_allclose(frames.poses[:, 0], 0.1 * np.arange(5))
    assert np.shares_memory(moved.points, frames.points)


def embedded(poses):
    return np.column_stack((poses[:, :2], np.cos(poses[:, 2]), np.sin(poses[:, 2])))


@given(st.integers(0, 2**32 - 1), st.integers(0, 60), st.integers(1, 9), st.floats(0.3, 6.0))
def test_nearest_poses_are_those_of_a_tree(seed, count, near, radius):
    rng = np.random.default_rng(seed)
    poses, queries = rng.uniform(-8.0, 8.0, (count, 3)), rng.uniform(-12.0, 12.0, (20, 3))
    found = nearest_poses(queries, poses, near, radius)
    assert found.shape == (20, near)
    if count:
        _, expected = cKDTree(embedded(poses)).query(embedded(queries), near, distance_upper_bound=radius)
        np.testing.assert_array_equal(found, np.where(expected == count, -1, expected).reshape(20, near))
    else:
        assert (found == -1).all()


def test_poses_far_apart_get_larger_buckets(monkeypatch):
    monkeypatch.setattr(near_poses, "MOST_BUCKETS", 16)
    poses = np.array([(0.0, 0.0, 0.0), (1e6, 1e6, 0.0), (1e6 + 0.5, 1e6, 0.0)])
    np.testing.assert_array_equal(nearest_poses(poses, poses, 2, 1.0), [(0, -1), (1, 2), (2, 1)])
