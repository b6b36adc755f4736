"""Pose estimate from particles."""

import math

import numpy as np

from ppaas.localization.kernels.bins import bin_of
from ppaas.localization.pose_estimate import estimate


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
