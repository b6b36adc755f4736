import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.localization.kernels import motion
from tests.reference.driving import localization as twin

seeds = st.integers(0, 2**32 - 1)


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
