import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from robots.sim.kernels.nearest import nearest
from tests.reference.driving import nearest as twin


@given(st.integers(0, 10_000), st.integers(0, 30), st.floats(0.05, 1.0))
def test_nearest_points_equal_those_of_the_twin(seed: int, count: int, reach: float) -> None:
    rng = np.random.default_rng(seed)
    points, others = rng.uniform(-1.0, 1.0, (20, 4)), rng.uniform(-1.0, 1.0, (count, 4))
    assert nearest(points, others, reach).tolist() == twin.nearest(points, others, reach)


def test_the_first_of_equally_near_points_is_taken() -> None:
    assert nearest(np.zeros((1, 4)), np.array([[0.1, 0.0, 0.0, 0.0], [-0.1, 0.0, 0.0, 0.0]]), 0.5).tolist() == [0]
