import math

import numpy as np
import pytest
from hypothesis import given
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra as scipy_dijkstra

from ppaas.errors import GoalOccupied, GoalOutsideMap, InvalidInput
from ppaas.planners.field.cost_field import CostField, cost_field
from ppaas.planners.weights import RELATIVE_ERROR, SCALE
from tests.reference.planners import dijkstra as twin
from tests.support.world import grids


@given(grids.scenes())
def test_field_equals_the_fixed_point_twin(scene):
    costs, goals, allow_unknown = scene
    values = cost_field(grids.of(costs), cells=goals, allow_unknown=allow_unknown)
    units = np.where(np.isinf(values), -1, np.rint(values * SCALE)).astype(int)
    assert units.tolist() == twin.fixed_field(costs, goals, allow_unknown)


@given(grids.scenes())
def test_field_is_within_its_error_bound_of_the_float_twin(scene):
    costs, goals, allow_unknown = scene
    values = cost_field(grids.of(costs), cells=goals, allow_unknown=allow_unknown)
    exact = twin.cost_field(costs, goals, allow_unknown)
    assert np.array_equal(np.isinf(values), np.isinf(exact))
    reached = ~np.isinf(exact)
    assert np.all(np.abs(values[reached] - exact[reached]) <= exact[reached] * RELATIVE_ERROR + 1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_the_field_agrees_with_scipy_on_larger_grids(seed):
    rng = np.random.default_rng(seed)
    costs = rng.integers(0, 253, (60, 45)).astype(np.uint8)
    costs[rng.random(costs.shape) < 0.3] = 254
    costs[rng.random(costs.shape) < 0.1] = 255
    goal = grids.free_cells(costs, True)[rng.integers(100)]
    sources, targets, weights = zip(*twin.edges(costs), strict=True)
    graph = coo_array((weights, (sources, targets)), shape=(costs.size, costs.size)).tocsr()
    exact = scipy_dijkstra(graph, indices=goal[0] * costs.shape[1] + goal[1]).reshape(costs.shape)
    np.testing.assert_allclose(cost_field(grids.of(costs), cells=goal), exact, rtol=RELATIVE_ERROR)


def test_a_path_cost_beyond_32_bits_is_exact():
    snake = np.zeros((1_201, 1_801), np.uint8)
    snake[1::2] = 254
    snake[1::4, -1] = 0
    snake[3::4, 0] = 0
    moves = 601 * 1_801 + 600 - 1
    field = CostField(grids.of(snake), np.array([(0, 0)]))
    assert field.grow((1_200, 1_800))
    assert field.values()[1_200, 1_800] == moves * 50.0
    assert moves * 50.0 * SCALE > 2**32
    assert len(field.path_from((1_200, 1_800))) == moves + 1


def test_early_stop_leaves_the_rest_unsettled_and_the_path_exact():
    map_ = grids.of(np.zeros((400, 400), np.uint8))
    field = CostField(map_, np.array([(200, 200)]))
    assert field.grow((200, 210))
    assert field.settled < 2_000
    assert field.path_from((200, 210)).tolist() == [[200, c] for c in range(210, 199, -1)]


@given(grids.scenes())
def test_values_of_single_cells_equal_those_of_the_whole_field(scene):
    costs, goals, allow_unknown = scene
    field = CostField(grids.of(costs), np.array(goals), allow_unknown=allow_unknown)
    field.grow()
    cells = np.argwhere(costs >= 0)
    assert np.array_equal(field.values_at(cells), field.values().ravel())


def test_goals_may_be_given_in_metres():
    map_ = grids.costmap("....\n....", resolution=0.5)
    assert np.array_equal(cost_field(map_, (1.2, 0.3)), cost_field(map_, cells=(0, 2)))
    assert np.array_equal(cost_field(map_, [(1.2, 0.3), (0.1, 0.9)]), cost_field(map_, cells=[(0, 2), (1, 0)]))


def test_a_cell_behind_walls_is_infinitely_far():
    assert cost_field(grids.costmap(".#."), cells=(0, 0)).tolist() == [[0.0, math.inf, math.inf]]


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ({}, InvalidInput),
        ({"goal_xy": (0.5, 0.5), "cells": (0, 0)}, InvalidInput),
        ({"goal_xy": (math.nan, 0.5)}, InvalidInput),
        ({"cells": np.empty((0, 2))}, InvalidInput),
        ({"cells": (0, 0, 0)}, InvalidInput),
        ({"cells": (0, 3)}, GoalOutsideMap),
        ({"goal_xy": (-0.1, 0.5)}, GoalOutsideMap),
        ({"cells": (0, 1)}, GoalOccupied),
        ({"cells": (0, 2), "allow_unknown": False}, GoalOccupied),
    ],
)
def test_invalid_goals_are_refused(arguments, error):
    with pytest.raises(error):
        cost_field(grids.costmap(".#?"), **arguments)


def test_values_at_cells_equal_values_of_the_whole_field():
    rng = np.random.default_rng(9)
    map_ = grids.of(rng.integers(0, 256, (70, 130)).astype(np.uint8))
    field = CostField(map_, np.array([grids.free_cells(map_.data, True)[0]]))
    field.grow((40, 99))
    cells = np.argwhere(np.ones((70, 130)))
    assert np.array_equal(field.values_at(cells), field.values().ravel())
