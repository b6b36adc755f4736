"""The kernels of localization do what their twins do."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.costmap.build import build_layers
from ppaas.geometry import Pose2D
from ppaas.localization.kernels import cluster, likelihood_field, motion, resample
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.particle_filter import ParticleFilter
from ppaas.maps.grid import GridInfo, GridMap
from tests.reference import localization as twin

seeds = st.integers(0, 2**32 - 1)


@settings(deadline=None)
@given(seeds, st.floats(-math.pi, math.pi), st.floats(0, 3), st.floats(-math.pi, math.pi))
def test_motion_moves_as_its_twin(seed, first, distance, second):
    rng = np.random.default_rng(seed)
    particles = rng.uniform(-5, 5, (20, 3))
    alphas, normals = rng.uniform(0, 0.5, 4), rng.standard_normal((20, 3))
    expected = twin.sample_motion(particles, first, distance, second, alphas, normals)
    motion.sample_motion(particles, first, distance, second, alphas, normals)
    np.testing.assert_allclose(particles[:, :2], expected[:, :2], atol=1e-9)
    turned = (particles[:, 2] - expected[:, 2] + math.pi) % (2 * math.pi) - math.pi
    np.testing.assert_allclose(turned, 0.0, atol=1e-9)


def test_without_noise_a_motion_is_exact():
    particles = np.array([[1.0, 2.0, math.pi / 2]])
    motion.sample_motion(particles, math.pi / 2, 3.0, -math.pi / 2, np.zeros(4), np.ones((1, 3)))
    np.testing.assert_allclose(particles, [[-2.0, 2.0, math.pi / 2]], atol=1e-12)


@settings(deadline=None)
@given(seeds, st.floats(-math.pi, math.pi))
def test_scans_are_scored_as_by_their_twin(seed, turned):
    rng = np.random.default_rng(seed)
    info = GridInfo(0.1, 30, 20, Pose2D(-1.0, 0.5, turned))
    squares = rng.integers(0, 900, info.shape)
    distance = (info.resolution * np.sqrt(squares)).astype(np.float32)
    particles = rng.uniform(-2, 3, (8, 3))
    beams = rng.uniform(-2, 2, (10, 2))
    expected = twin.score_scan(particles, beams, distance, info, 0.95, 0.01, 0.2, 2.0)
    found = likelihood_field.score_scan(
        particles, beams, distance, info.resolution, np.array(info.origin),
        likelihood_field.likelihoods(info.resolution, 0.95, 0.01, 0.2, 2.0),
    )  # fmt: skip
    # A beam that ends within rounding of the edge of a cell may be read off its neighbour.
    assert np.mean(np.isclose(found, expected, rtol=1e-9)) >= 0.8


def test_a_particle_whose_beams_end_on_the_wall_outweighs_one_beside():
    info = GridInfo(0.05, 100, 100)
    likelihood = likelihood_field.likelihoods(info.resolution, 0.95, 0.01, 0.2, 2.0)
    distance = np.abs(np.arange(100) * 0.05 - 4.0)[None].repeat(100, 0).astype(np.float32)
    beams = np.array([[2.0, 0.0], [2.0, 0.5], [2.0, -0.5]])
    on, beside = likelihood_field.score_scan(
        np.array([[2.0, 2.5, 0.0], [1.5, 2.5, 0.0]]), beams, distance, 0.05, np.array(info.origin), likelihood
    )
    assert 1.0 <= beside < 2.0
    assert on > 3.0


def test_the_table_of_likelihoods_is_bounded_whatever_the_parameters_and_ends_with_what_is_far():
    table = likelihood_field.likelihoods(0.05, 0.95, 0.1, 1e9, 1e12)
    assert len(table) <= likelihood_field.MOST_SQUARES + 1
    assert likelihood_field.likelihoods(0.05, 0.95, 0.1, 0.2, 1e12)[-1] == pytest.approx(0.1**3)


@settings(deadline=None)
@given(seeds, st.floats(-4, 4))
def test_the_mean_around_a_pose_is_that_of_its_twin(seed, theta):
    rng = np.random.default_rng(seed)
    particles = rng.normal((1.0, 2.0, theta), (0.6, 0.6, 0.7), (50, 3))
    particles[0] = 1.0, 2.0, theta
    weights = rng.uniform(0.1, 1.0, 50)
    x, y, mean_theta = cluster.mean_around(particles, weights, Pose2D(1.0, 2.0, theta), 0.75, 0.8)
    expected = twin.mean_around(particles, weights, Pose2D(1.0, 2.0, theta), 0.75, 0.8)
    assert (x, y) == pytest.approx(expected[:2])
    assert math.remainder(mean_theta - expected[2], 2 * math.pi) == pytest.approx(0.0, abs=1e-9)


@given(st.lists(st.floats(0, 1), min_size=1, max_size=50), st.integers(1, 200), st.floats(0, 1, exclude_max=True))
def test_particles_are_drawn_as_by_their_twin(weights, count, start):
    weights = np.array(weights) + 1e-6
    weights /= weights.sum()
    drawn = resample.draw_low_variance(weights, count, start)
    assert (drawn == twin.draw_low_variance(weights, count, start)).all()


@given(st.lists(st.floats(0.001, 1), min_size=1, max_size=50), st.integers(1, 200), st.floats(0, 1, exclude_max=True))
def test_each_particle_is_drawn_as_often_as_it_weighs_give_or_take_one(weights, count, start):
    weights = np.array(weights) / np.sum(weights)
    drawn = np.bincount(resample.draw_low_variance(weights, count, start), minlength=len(weights))
    assert (np.abs(drawn - count * weights) <= 1.0 + 1e-9).all()


@pytest.mark.parametrize(
    ("module", "kernel"),
    [
        (likelihood_field, likelihood_field.score_scan),
        (motion, motion.sample_motion),
        (resample, resample.draw_low_variance),
    ],
)
def test_a_warm_kernel_compiles_nothing_more_for_what_production_calls_it_with(module, kernel):
    module.warm()
    warm = list(kernel.signatures)
    parameters = AmclParameters(min_particles=10, max_particles=10, resample_interval=1)
    info = GridInfo(0.05, 20, 20)
    grid = GridMap(np.eye(20, dtype=np.int8) * 100, info)
    localization = ParticleFilter(build_layers(grid), parameters)
    for x in (0.0, 0.5):
        localization.update(Pose2D(x, 0, 0), np.array([[0.1, 0.2]]), 8.0)
    assert kernel.signatures == warm
