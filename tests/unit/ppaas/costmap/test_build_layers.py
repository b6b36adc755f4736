"""The layers of a map."""

import numpy as np
import pytest
from hypothesis import given, settings

from ppaas.costmap.build_layers import build_layers, recosted, without_unknown
from ppaas.costmap.filter_masks import barred, raise_costs
from ppaas.costmap.global_parameters import CostParameters
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.maps.free_space import distance_to_occupied
from ppaas.maps.grid import GridInfo, GridMap
from tests.reference.maps.costmaps import static_costmap
from tests.support.budget import examples
from tests.support.world.maps import grid_maps, real_map


@given(grid_maps([-1, 0, 30, 65, 100], most=20))
def test_costmap_equals_the_static_layer_beyond_the_inflation(grid):
    layers = build_layers(grid)
    static = static_costmap(grid).data
    assert layers.grid is grid
    assert layers.costmap.info == grid.info
    assert np.array_equal(layers.costmap.data == 254, static == 254)
    far = layers.distance > 0.56
    assert np.array_equal(layers.costmap.data[far], static[far])


@given(grid_maps([-1, 0, 100], most=20))
def test_larger_robot_never_has_lower_costs(grid):
    small = build_layers(grid, robot_radius=0.1).costmap.data
    large = build_layers(grid, robot_radius=0.3).costmap.data
    known = (small != 255) & (large != 255)
    assert (large[known] >= small[known]).all()


def test_a_parameter_out_of_range_is_named():
    grid = GridMap(np.zeros((1, 1), np.int8), GridInfo(0.05, 1, 1))
    with pytest.raises(InvalidParameter, match="inscribed_radius"):
        build_layers(grid, robot_radius=-1.0)


def masked(grid: GridMap) -> MapLayers:
    """Return the layers of a map with a random keep-out mask, whose cells are twice as large."""
    height, width = grid.info.shape
    data = np.random.default_rng(height).choice(np.array([-1, 0, 0, 40, 100], np.int8), (height, width))
    origin = grid.info.origin @ Pose2D(0.3, 0.2)
    return build_layers(grid, keepout=GridMap(data, GridInfo(2.0 * grid.info.resolution, width, height, origin)))


@settings(max_examples=examples(15))
@given(grid_maps([-1, 0, 100], most=20))
def test_keepout_zones_are_inflated_like_obstacles(grid):
    layers = masked(grid)
    as_obstacles = build_layers(barred(grid, layers.keepout))
    expected = as_obstacles.costmap.data.copy()
    raise_costs(expected, layers.keepout.data)
    assert np.array_equal(layers.costmap.data, expected)
    assert np.array_equal(layers.to_lethal, as_obstacles.distance)
    assert (layers.costmap.data[layers.keepout.data == 100] == 254).all()


@settings(max_examples=examples(15))
@given(grid_maps([-1, 0, 100], most=20))
def test_masks_do_not_affect_localization(grid):
    layers, bare = masked(grid), build_layers(grid)
    assert np.array_equal(layers.distance, bare.distance)
    assert layers.grid is grid
    assert bare.to_lethal is bare.distance
    known = layers.costmap.data != 255
    assert (layers.costmap.data[known] >= np.where(bare.costmap.data == 255, 0, bare.costmap.data)[known]).all()


@pytest.mark.parametrize(("threshold", "lethal"), [(1, [30, 65, 100]), (65, [65, 100]), (66, [100]), (100, [100])])
@pytest.mark.parametrize("mask", [False, True])
def test_cells_from_the_lethal_threshold_on_are_obstacles(threshold, lethal, mask):
    values = np.array([[0, 30, 65, 100, -1]], np.int8).repeat(3, axis=0)
    grid = GridMap(values, GridInfo(1.0, 5, 3))
    keepout = GridMap(np.zeros((3, 5), np.int8), grid.info) if mask else None
    layers = build_layers(grid, robot_radius=0.1, lethal_cost_threshold=threshold, keepout=keepout)
    assert np.array_equal(layers.costmap.data == 254, np.isin(values, lethal))
    assert np.array_equal(layers.to_lethal == 0, np.isin(values, lethal))
    assert np.array_equal(layers.distance == 0, values >= 65)


@given(grid_maps([-1, 0, 50, 80, 100], most=20))
def test_a_recosted_map_equals_one_built_with_the_same_parameters(grid):
    costs = CostParameters(0.3, 3.0, 70)
    built = build_layers(
        grid, robot_radius=0.1, inflation_radius=0.3, cost_scaling_factor=3.0, lethal_cost_threshold=70
    )
    assert np.array_equal(recosted(build_layers(grid), 0.1, costs).data, built.costmap.data)
    usual = build_layers(grid, robot_radius=0.4).costmap
    assert np.array_equal(recosted(build_layers(grid), 0.4, CostParameters()).data, usual.data)


@pytest.mark.parametrize("name", ["turtlebot3", "warehouse"])
def test_layers_of_real_maps_are_consistent(data, name):
    grid = real_map(data, name)
    layers = build_layers(grid)
    assert np.array_equal(layers.distance, distance_to_occupied(grid))
    assert np.array_equal(layers.costmap.data >= 253, (layers.distance <= 0.18) | (layers.costmap.data == 255))


def test_layers_without_unknown_cells_are_those_of_a_map_in_which_they_are_free():
    random = np.random.default_rng(5)
    cells = random.choice(np.array([-1, 0, 100], np.int8), size=(40, 30), p=[0.3, 0.66, 0.04])
    info, costs = GridInfo(0.1, 30, 40), CostParameters(0.4, 3.0)
    mask = GridMap(random.choice(np.array([0, 30, 100], np.int8), size=info.shape, p=[0.9, 0.06, 0.04]), info)
    settings = {"robot_radius": 0.2, "inflation_radius": 0.4, "cost_scaling_factor": 3.0, "keepout": mask}
    known = build_layers(GridMap(np.maximum(cells, 0), info), **settings)
    made = without_unknown(build_layers(GridMap(cells, info), **settings), 0.2, costs)
    np.testing.assert_array_equal(made.costmap.data, known.costmap.data)
    np.testing.assert_array_equal(made.grid.data, known.grid.data)
    assert (made.to_lethal == known.to_lethal).all() and made.keepout is not None


@pytest.mark.parametrize("threads", [1, 2])
def test_layers_do_not_depend_on_the_number_of_threads(threads):
    cells = np.random.default_rng(7).choice(np.array([-1, 0, 100], np.int8), size=(500, 400), p=[0.3, 0.69, 0.01])
    grid = GridMap(cells, GridInfo(0.05, 400, 500))
    usual, limited = build_layers(grid), build_layers(grid, threads=threads)
    np.testing.assert_array_equal(limited.costmap.data, usual.costmap.data)
    np.testing.assert_array_equal(limited.distance, usual.distance)
