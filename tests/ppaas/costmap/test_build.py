"""The layers of a map."""

import numpy as np
import pytest
from hypothesis import given, settings

from ppaas.costmap.build import build_layers
from ppaas.costmap.static import static_costmap
from ppaas.errors import InvalidParameter
from ppaas.maps.distance import distance_to_occupied
from ppaas.maps.grid import GridInfo, GridMap
from tests.support.maps import grid_maps, real_map


@settings(deadline=None)
@given(grid_maps([-1, 0, 30, 65, 100], most=20))
def test_the_costmap_agrees_with_the_static_layer_where_nothing_is_inflated(grid):
    layers = build_layers(grid)
    static = static_costmap(grid).data
    assert layers.grid is grid
    assert layers.costmap.info == grid.info
    assert np.array_equal(layers.costmap.data == 254, static == 254)
    far = layers.distance > 0.56
    assert np.array_equal(layers.costmap.data[far], static[far])


@settings(deadline=None)
@given(grid_maps([-1, 0, 100], most=20))
def test_a_larger_robot_never_costs_less(grid):
    small = build_layers(grid, robot_radius=0.1).costmap.data
    large = build_layers(grid, robot_radius=0.3).costmap.data
    known = (small != 255) & (large != 255)
    assert (large[known] >= small[known]).all()


def test_a_parameter_out_of_range_is_named():
    grid = GridMap(np.zeros((1, 1), np.int8), GridInfo(0.05, 1, 1))
    with pytest.raises(InvalidParameter, match="inscribed_radius"):
        build_layers(grid, robot_radius=-1.0)


@pytest.mark.parametrize("name", ["turtlebot3", "warehouse"])
def test_the_layers_of_real_maps(data, name):
    grid = real_map(data, name)
    layers = build_layers(grid)
    assert np.array_equal(layers.distance, distance_to_occupied(grid))
    assert np.array_equal(layers.costmap.data >= 253, (layers.distance <= 0.18) | (layers.costmap.data == 255))
