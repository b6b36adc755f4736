import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.localization.kernels import cluster
from tests.reference.driving import localization as twin

seeds = st.integers(0, 2**32 - 1)


@given(seeds, st.floats(-4, 4))
def test_moments_around_a_pose_agree_with_the_twin(seed, theta):
    rng = np.random.default_rng(seed)
    particles = rng.normal((1.0, 2.0, theta), (0.6, 0.6, 0.7), (50, 3))
    particles[0] = 1.0, 2.0, theta
    weights = rng.uniform(0.1, 1.0, 50)
    total, mean, covariance = cluster.moments_around(particles, weights, Pose2D(1.0, 2.0, theta), 0.75, 0.8)
    expected = twin.moments_around(particles, weights, Pose2D(1.0, 2.0, theta), 0.75, 0.8)
    assert total == pytest.approx(expected[0])
    assert mean[:2] == pytest.approx(expected[1][:2])
    assert math.remainder(mean[2] - expected[1][2], 2 * math.pi) == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(covariance, expected[2], atol=1e-9)


def test_pose_without_near_particles_has_no_weight_and_is_unchanged():
    total, mean, _ = cluster.moments_around(np.zeros((1, 3)), np.ones(1), Pose2D(9.0, 9.0, 1.0), 0.75, 0.8)
    assert (total, mean) == (0.0, (9.0, 9.0, 1.0))


@given(seeds)
def test_heaviest_bin_agrees_with_the_twin(seed):
    rng = np.random.default_rng(seed)
    particles, weights = rng.normal(0.0, 0.6, (60, 3)), rng.uniform(0.1, 1.0, 60)
    sums: dict[tuple[int, int, int], float] = {}
    for particle, weight in zip(particles, weights, strict=True):
        sums[twin.bin_of(particle)] = sums.get(twin.bin_of(particle), 0.0) + weight
    assert twin.bin_of(particles[cluster.heaviest_bin(particles, weights)]) == max(sums, key=sums.__getitem__)
