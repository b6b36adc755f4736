"""Pose estimate from particles."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.localization.kernels import cluster
from ppaas.localization.kernels.bins import bin_of
from ppaas.localization.pose_estimate import estimate
from tests.reference.driving import localization as twin


def cloud(centre, spread, count, seed=0):
    return np.random.default_rng(seed).normal(centre, spread, (count, 3))


def even(count):
    return np.full(count, 1.0 / count)


def test_mean_and_covariance_are_those_of_the_particles():
    particles = cloud((2.0, -3.0, 0.5), (0.1, 0.05, 0.02), 5000)
    found = estimate(particles, even(5000))
    np.testing.assert_allclose(found.pose, (2.0, -3.0, 0.5), atol=0.01)
    np.testing.assert_allclose(np.diag(found.covariance), (0.01, 0.0025, 0.0004), rtol=0.1)


def test_mean_of_headings_around_pi_is_pi():
    particles = cloud((0.0, 0.0, math.pi), (0.01, 0.01, 0.1), 1000)
    particles[:, 2] = (particles[:, 2] + math.pi) % (2 * math.pi) - math.pi
    found = estimate(particles, even(1000))
    assert abs(abs(found.pose.theta) - math.pi) < 0.02
    assert found.covariance[2, 2] < 0.02


def test_estimate_uses_the_heavier_cluster_only():
    near, far = cloud((0.0, 0.0, 0.0), 0.05, 600), cloud((8.0, 0.0, 0.0), 0.05, 400)
    found = estimate(np.concatenate((near, far)), even(1000))
    assert abs(found.pose.x) < 0.02
    assert found.covariance[0, 0] < 0.01
    assert abs(found.share - 0.6) < 1e-9


def test_mean_is_weighted():
    particles = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]])
    assert math.isclose(estimate(particles, np.array([0.25, 0.75])).pose.x, 0.075)


def test_poses_in_different_bins_have_different_bin_numbers():
    particles = np.array(
        [[0.1, 0.1, 0.05], [0.4, 0.4, 0.1], [-0.1, 0.1, 0.05], [0.1, -0.1, 0.05], [0.1, 0.1, -0.05], [0.6, 0.1, 0.05]]
    )
    first, same, *others = (bin_of(*particle) for particle in particles.tolist())
    assert first == same
    assert len({first, *others}) == 5


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
