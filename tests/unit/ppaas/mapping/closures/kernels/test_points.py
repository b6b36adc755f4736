import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.mapping.closures.kernels import points as kernels
from tests.reference.mapping import closures as twin

seeds = st.integers(0, 2**32 - 1)


@given(seeds)
def test_gathered_points_equal_the_twin(seed):
    rng = np.random.default_rng(seed)
    points, valid = rng.normal(size=(3, 5, 2)).astype(np.float32), rng.random((3, 5)) < 0.7
    poses, frame = rng.normal(size=(3, 3)), rng.normal(size=3)
    found = kernels.gather(points, valid, poses, frame)
    np.testing.assert_allclose(found, twin.gather(points, valid, poses, frame), atol=1e-12)


@given(seeds)
def test_thinned_points_equal_the_twin(seed):
    points = np.random.default_rng(seed).uniform(-1.2, 1.2, (40, 2))
    np.testing.assert_allclose(kernels.thin(points, 0.3, 1.0), twin.thin(points, 0.3, 1.0), atol=1e-12)


def test_no_points_stay_no_points():
    assert kernels.thin(np.empty((0, 2)), 0.1, 5.0).shape == (0, 2)
