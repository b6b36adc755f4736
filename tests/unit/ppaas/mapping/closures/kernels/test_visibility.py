import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.mapping.closures.kernels.visibility import agreement
from tests.reference.mapping import closures as twin

BEAMS, STEP = 60, math.radians(3.0)


def scan(ranges):
    angles = -math.pi / 2 + STEP * np.arange(BEAMS)
    return (ranges[:, None] * np.stack((np.cos(angles), np.sin(angles)), axis=1)).astype(np.float32)


@given(st.integers(0, 2**32 - 1))
def test_numbers_equal_those_of_the_twin(seed):
    rng = np.random.default_rng(seed)
    one, two = scan(rng.uniform(1, 4, BEAMS)), scan(rng.uniform(1, 4, BEAMS))
    valid, other = rng.random(BEAMS) < 0.9, rng.random(BEAMS) < 0.9
    given = (one, valid, two, other, rng.normal(size=3), -math.pi / 2, STEP, 0.3)
    assert agreement(*given) == twin.agreement(*given)


def test_wall_within_free_space_is_contradicted_and_hidden_wall_is_not():
    near, far, valid = scan(np.full(BEAMS, 2.0)), scan(np.full(BEAMS, 3.0)), np.ones(BEAMS, bool)
    here = np.zeros(3)
    assert agreement(near, valid, far, valid, here, -math.pi / 2, STEP, 0.3) == (0, BEAMS - 2)
    assert agreement(far, valid, near, valid, here, -math.pi / 2, STEP, 0.3) == (0, 0)
    assert agreement(near, valid, near, valid, here, -math.pi / 2, STEP, 0.3) == (BEAMS - 2, 0)
