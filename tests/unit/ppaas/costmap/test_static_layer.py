"""What the map itself says."""

import numpy as np
from hypothesis import given, settings

from ppaas.costmap.static_layer import static_costmap
from ppaas.maps.grid import GridInfo, GridMap
from tests.support.world.maps import grid_maps


def test_occupied_is_lethal_unknown_is_unknown_and_the_rest_free():
    grid = GridMap(np.array([[-1, 0, 1, 64, 65, 99, 100]], np.int8), GridInfo(0.05, 7, 1))
    assert static_costmap(grid).data.tolist() == [[255, 0, 0, 0, 254, 254, 254]]


@settings(deadline=None)
@given(grid_maps([-1, 0, 100]))
def test_it_lies_where_the_map_lies(grid):
    assert static_costmap(grid).info == grid.info
