import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from ppaas.controllers.obstacles import distance_to_lethal
from tests.support.world import grids


@pytest.mark.parametrize("allow_unknown", [True, False])
def test_distances_are_to_lethal_and_disallowed_unknown_cells(allow_unknown):
    data = np.random.default_rng(1).choice(np.array([0, 200, 253, 254, 255], np.uint8), (30, 40), p=[0.9, *[0.025] * 4])
    blocked = (data == 254) | ((data == 255) & (not allow_unknown))
    got = distance_to_lethal(grids.of(data, 0.05), allow_unknown=allow_unknown)
    assert got == pytest.approx(distance_transform_edt(~blocked) * 0.05, abs=1e-5)


def test_distance_without_lethal_cells_exceeds_the_costmap():
    assert (distance_to_lethal(grids.of(np.full((4, 5), 253, np.uint8), 0.05), allow_unknown=True) > 5 * 0.05).all()
