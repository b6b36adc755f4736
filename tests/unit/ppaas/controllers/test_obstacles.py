import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from ppaas.controllers.obstacles import distance_to_lethal
from tests.support.world import grids


@pytest.mark.parametrize("allow_unknown", [True, False])
def test_distances_are_those_to_lethal_cells_and_to_unknown_ones_where_they_are_not_allowed(allow_unknown):
    data = np.random.default_rng(1).choice(np.array([0, 200, 253, 254, 255], np.uint8), (30, 40), p=[0.9, *[0.025] * 4])
    blocked = (data == 254) | ((data == 255) & (not allow_unknown))
    got = distance_to_lethal(grids.of(data, 0.05), allow_unknown=allow_unknown)
    assert got == pytest.approx(distance_transform_edt(~blocked) * 0.05, abs=1e-5)


def test_where_nothing_is_lethal_it_is_farther_than_the_costmap_reaches():
    assert (distance_to_lethal(grids.of(np.full((4, 5), 253, np.uint8), 0.05), allow_unknown=True) > 5 * 0.05).all()
