import math

import numpy as np
import pytest

from robots.sim.kernels.discs import cast_at_discs


def test_a_ray_ends_at_the_nearest_disc_in_front() -> None:
    centres = np.array([[3.0, 0.0], [2.0, 0.05], [-1.0, 0.0]])
    ranges = cast_at_discs(0.0, 0.0, np.array([0.0, math.pi, math.pi / 2]), centres, 0.1)
    assert ranges[0] == pytest.approx(2.0 - math.sqrt(0.1**2 - 0.05**2))
    assert ranges[1] == pytest.approx(0.9)
    assert ranges[2] == math.inf
