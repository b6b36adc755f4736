import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.sim.kernels.discs import box_clearance, cast_at_discs


@given(st.integers(0, 10_000), st.floats(-3.2, 3.2))
def test_box_clearance_equals_that_of_its_nearest_point(seed: int, theta: float) -> None:
    rng = np.random.default_rng(seed)
    centres, radius = rng.uniform(-1.5, 1.5, (4, 2)), 0.1
    got = box_clearance(0.1, -0.2, theta, 0.254, 0.215, centres, radius)
    across, up = np.meshgrid(np.linspace(-0.254, 0.254, 150), np.linspace(-0.215, 0.215, 150))
    x = 0.1 + math.cos(theta) * across - math.sin(theta) * up
    y = -0.2 + math.sin(theta) * across + math.cos(theta) * up
    measured = min(float(np.hypot(x - cx, y - cy).min()) for cx, cy in centres.tolist()) - radius
    if measured > -radius + 0.005:
        assert got == pytest.approx(measured, abs=0.004)
    else:
        assert got <= -radius + 0.005


def test_clearance_decreases_with_the_depth_of_a_disc_in_the_box() -> None:
    depths = [box_clearance(0.0, 0.0, 0.0, 0.5, 0.3, np.array([[0.0, y]]), 0.1) for y in (0.5, 0.35, 0.3, 0.1)]
    assert depths == pytest.approx([0.1, -0.05, -0.1, -0.3])


def test_a_ray_ends_at_the_nearest_disc_in_front() -> None:
    centres = np.array([[3.0, 0.0], [2.0, 0.05], [-1.0, 0.0]])
    ranges = cast_at_discs(0.0, 0.0, np.array([0.0, math.pi, math.pi / 2]), centres, 0.1)
    assert ranges[0] == pytest.approx(2.0 - math.sqrt(0.1**2 - 0.05**2))
    assert ranges[1] == pytest.approx(0.9)
    assert ranges[2] == math.inf
