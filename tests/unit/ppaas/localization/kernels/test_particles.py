"""Kernels of the particle filter: resampling, motion, free cells, and their compilation ahead of time."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.localization.kernels import cluster, free_cells, likelihood_field, motion, resample
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.particle_filter import ParticleFilter
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap
from tests.reference.driving import localization as twin

seeds = st.integers(0, 2**32 - 1)


@given(seeds, st.floats(0.1, 3.0), st.integers(1, 50))
def test_kld_sample_size_agrees_with_the_twin(seed, spread, least):
    rng = np.random.default_rng(seed)
    particles, weights, picks = rng.normal(0.0, spread, (300, 3)), rng.uniform(0.0, 1.0, 300), rng.random(400)
    expected = twin.kld_sample_size(particles, weights, picks, least, 0.05, 0.99)
    assert resample.kld_sample_size(particles, weights, picks, least, 0.05, 0.99) == expected


@given(st.lists(st.floats(0, 1), min_size=1, max_size=50), st.integers(1, 200), st.floats(0, 1, exclude_max=True))
def test_drawn_particles_agree_with_the_twin(weights, count, start):
    weights = np.array(weights) + 1e-6
    weights /= weights.sum()
    drawn = resample.draw_low_variance(weights, count, start)
    assert (drawn == twin.draw_low_variance(weights, count, start)).all()


@given(st.lists(st.floats(0.001, 1), min_size=1, max_size=50), st.integers(1, 200), st.floats(0, 1, exclude_max=True))
def test_particle_is_drawn_in_proportion_to_its_weight_within_one(weights, count, start):
    weights = np.array(weights) / np.sum(weights)
    drawn = np.bincount(resample.draw_low_variance(weights, count, start), minlength=len(weights))
    assert (np.abs(drawn - count * weights) <= 1.0 + 1e-9).all()


MOVES = [
    (motion.move_diff_serial, twin.move_diff),
    (motion.move_diff_parallel, twin.move_diff),
    (motion.move_omni_serial, twin.move_omni),
    (motion.move_omni_parallel, twin.move_omni),
]


@pytest.mark.parametrize(("move", "slow"), MOVES)
@given(seeds, st.floats(-math.pi, math.pi), st.floats(0, 3), st.floats(-math.pi, math.pi))
def test_moves_agree_with_the_twin(move, slow, seed, first, second, third):
    rng = np.random.default_rng(seed)
    particles = rng.uniform(-5, 5, (20, 3))
    sigmas, normals = tuple(rng.uniform(0, 0.5, 3)), rng.standard_normal((20, 3))
    expected = slow(particles, (first, second, third), sigmas, normals)
    move(particles, (first, second, third), sigmas, normals)
    np.testing.assert_allclose(particles[:, :2], expected[:, :2], atol=1e-9)
    turned = (particles[:, 2] - expected[:, 2] + math.pi) % (2 * math.pi) - math.pi
    np.testing.assert_allclose(turned, 0.0, atol=1e-9)


def test_motion_without_noise_is_exact():
    particles = np.array([[1.0, 2.0, math.pi / 2]])
    motion.move_diff_serial(particles, (math.pi / 2, 3.0, -math.pi / 2), (0.0, 0.0, 0.0), np.ones((1, 3)))
    np.testing.assert_allclose(particles, [[-2.0, 2.0, math.pi / 2]], atol=1e-12)


@given(seeds)
def test_free_cells_are_found_by_index(seed):
    rng = np.random.default_rng(seed)
    data = rng.choice(np.array([FREE, OCCUPIED, -1], np.int8), (rng.integers(1, 9), rng.integers(1, 9)))
    free = np.argwhere(data == FREE)
    below = free_cells.count_free(data)
    assert below[-1] == len(free)
    numbers = np.sort(rng.integers(0, len(free), 20)) if len(free) else np.empty(0, np.int64)
    np.testing.assert_array_equal(free_cells.find_free(data, below, numbers), free[numbers])


@pytest.mark.parametrize(
    ("module", "kernel"),
    [
        (likelihood_field, likelihood_field.score_serial),
        (motion, motion.move_diff_serial),
        (resample, resample.draw_low_variance),
        (resample, resample.kld_sample_size),
        (cluster, cluster.heaviest_bin),
        (cluster, cluster.moments_around),
    ],
)
def test_warm_kernel_compiles_no_more_signatures_in_use(module, kernel):
    module.warm()
    warm = list(kernel.signatures)
    parameters = AmclParameters(min_particles=10, max_particles=10, resample_interval=1)
    info = GridInfo(0.05, 20, 20)
    grid = GridMap(np.eye(20, dtype=np.int8) * 100, info)
    localization = ParticleFilter(build_layers(grid), parameters)
    for x in (0.0, 0.5):
        localization.update(Pose2D(x, 0, 0), np.array([[0.1, 0.2]]), 8.0)
    assert kernel.signatures == warm
