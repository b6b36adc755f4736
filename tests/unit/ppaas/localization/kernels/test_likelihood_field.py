import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.kernel_threads import limit_threads
from ppaas.localization.kernels import likelihood_field
from ppaas.maps.grid import GridInfo
from tests.reference.driving import localization as twin
from tests.support.world.scattered_walls import distances

seeds = st.integers(0, 2**32 - 1)


def cubes(resolution):
    likelihoods = likelihood_field.likelihoods(resolution, 0.95, 0.01, 0.2, 2.0)
    return np.rint(likelihoods**3 * likelihood_field.ONE).astype(np.int64)


@given(seeds, st.floats(-math.pi, math.pi))
def test_scan_scores_agree_with_the_twin(seed, yaw):
    rng = np.random.default_rng(seed)
    info = GridInfo(0.1, 30, 20, Pose2D(-1.0, 0.5, yaw))
    squares = rng.integers(0, 900, info.shape)
    distance = (info.resolution * np.sqrt(squares)).astype(np.float32)
    particles = rng.uniform(-2, 3, (8, 3))
    beams = rng.uniform(-2, 2, (10, 2))
    expected = twin.score_scan(particles, beams, distance, info, 0.95, 0.01, 0.2, 2.0)
    found = likelihood_field.score_serial(
        particles, beams, distance, info.resolution, np.array(info.origin), cubes(info.resolution)
    )
    # A beam that ends within rounding of the edge of a cell may be looked up in its neighbour.
    assert np.mean(np.isclose(found, expected, atol=1e-9)) >= 0.8


def test_particle_whose_beams_end_on_the_wall_scores_higher():
    distance = np.abs(np.arange(100) * 0.05 - 4.0)[None].repeat(100, 0).astype(np.float32)
    beams = np.array([[2.0, 0.0], [2.0, 0.5], [2.0, -0.5]])
    on, beside = likelihood_field.score_serial(
        np.array([[2.0, 2.5, 0.0], [1.5, 2.5, 0.0]]), beams, distance, 0.05, np.zeros(3), cubes(0.05)
    )
    assert 0.0 <= beside < 1.0
    assert on > 2.0


@pytest.mark.parametrize("threads", [2, 3])
def test_parallel_scores_are_bitwise_equal_to_serial(threads):
    rng = np.random.default_rng(5)
    distance, origin = distances(5, GridInfo(0.1, 30, 20)), np.zeros(3)
    particles, beams = rng.uniform(-1, 3, (1000, 3)), rng.uniform(-2, 2, (31, 2))
    with limit_threads(threads):
        fields = likelihood_field.score_parallel(particles, beams, distance, 0.1, origin, cubes(0.1))
    one = likelihood_field.score_serial(particles, beams, distance, 0.1, origin, cubes(0.1))
    np.testing.assert_array_equal(fields, one)


def test_likelihood_table_is_bounded_and_ends_with_the_far_value():
    table = likelihood_field.likelihoods(0.05, 0.95, 0.1, 1e9, 1e12)
    assert len(table) <= likelihood_field.MOST_SQUARES + 1
    assert likelihood_field.likelihoods(0.05, 0.95, 0.1, 0.2, 1e12)[-1] == pytest.approx(0.1)
