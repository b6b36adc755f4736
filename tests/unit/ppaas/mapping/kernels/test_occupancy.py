import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.mapping.kernels import occupancy as kernels
from tests.reference.mapping import scans
from tests.support.budget import examples


@settings(max_examples=examples(15))
@given(st.integers(0, 2**32 - 1))
def test_counts_agree_with_the_twin(seed):
    rng = np.random.default_rng(seed)
    poses = rng.uniform(-1.0, 1.0, (2, 3))
    points, valid = rng.uniform(-1.4, 1.4, (2, 12, 2)).astype(np.float32), rng.random((2, 12)) < 0.8
    ended, passed = np.zeros((80, 90), np.uint16), np.zeros((80, 90), np.uint16)
    kernels.count_beams(ended, passed, -4.0, -3.9, 0.1, poses, points, valid)
    ends, passes = scans.count_beams(ended.shape, -4.0, -3.9, 0.1, poses, points, valid)
    assert (ended != ends).sum() <= 2  # an end on the edge of a cell
    # Samples of the twin may miss corners of cells.
    assert (passed != passes).sum() <= 0.03 * passes.sum() + 3
    assert ended.sum() == valid.sum()


def test_counts_do_not_overflow():
    poses, points = np.zeros((70_000, 3)), np.full((70_000, 1, 2), 0.25, np.float32)
    ended, passed = np.zeros((2, 2), np.uint16), np.zeros((2, 2), np.uint16)
    kernels.count_beams(ended, passed, -0.05, -0.05, 0.2, poses, points, np.ones((70_000, 1), np.bool_))
    assert ended[1, 1] == passed[0, 0] == 65535
    assert ended.astype(int).sum() == 65535


def test_bounds_contain_poses_and_points():
    poses, points = np.array([(1.0, 2.0, np.pi / 2.0)]), np.array([[(3.0, 0.0), (99.0, 0.0)]], np.float32)
    found = kernels.bounds(poses, points, np.array([[True, False]]))
    np.testing.assert_allclose(found, (1.0, 2.0, 1.0, 5.0), atol=1e-12)
