import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.kernel_threads import limit_threads
from ppaas.localization.kernels import beam_model
from ppaas.maps.grid import GridInfo
from tests.reference.driving import localization as twin
from tests.support.budget import examples
from tests.support.world.scattered_walls import distances

seeds = st.integers(0, 2**32 - 1)


@settings(max_examples=examples(25))
@given(seeds, st.floats(-math.pi, math.pi))
def test_range_scores_agree_with_the_twin(seed, yaw):
    rng = np.random.default_rng(seed)
    info = GridInfo(0.1, 30, 20, Pose2D(-1.0, 0.5, yaw))
    distance = distances(seed, info)
    particles = rng.uniform(-2, 3, (8, 3))
    beams = np.column_stack([rng.uniform(-0.2, 0.2, (10, 2)), rng.uniform(-3, 3, 10), rng.uniform(0.1, 3.0, 10)])
    beams[:3, 3] = 3.0
    # A wide hit and a low weight of short ranges, so that half a cell makes little difference.
    shares = beam_model.BeamShares(0.9, 0.01, 0.05, 0.05, 0.5, 0.1)
    expected = twin.score_ranges(particles, beams, distance, info, shares, 3.0)
    found = beam_model.score_serial(particles, beams, distance, info.resolution, np.array(info.origin), shares, 3.0)
    np.testing.assert_allclose(found, expected, atol=10 * 3 * 0.9**3 * 0.1)
    assert np.median(np.abs(found - expected)) < 0.5


@pytest.mark.parametrize("threads", [2, 3])
def test_parallel_scores_are_bitwise_equal_to_serial(threads):
    rng = np.random.default_rng(5)
    distance, origin = distances(5, GridInfo(0.1, 30, 20)), np.zeros(3)
    particles = rng.uniform(-1, 3, (1000, 3))
    rays = np.column_stack([np.zeros((31, 2)), rng.uniform(-3, 3, 31), rng.uniform(0.1, 3.0, 31)])
    shares = beam_model.BeamShares(0.95, 0.1, 0.05, 0.05, 0.2, 0.1)
    with limit_threads(threads):
        ranges = beam_model.score_parallel(particles, rays, distance, 0.1, origin, shares, 3.0)
    np.testing.assert_array_equal(ranges, beam_model.score_serial(particles, rays, distance, 0.1, origin, shares, 3.0))
