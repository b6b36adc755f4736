import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from ppaas.mapping import near_poses
from ppaas.mapping.near_poses import nearest_poses


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
