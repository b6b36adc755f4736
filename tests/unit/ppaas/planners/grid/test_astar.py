"""A* finds paths as cheap as Dijkstra's algorithm, and settles no more cells."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ppaas.errors import NoValidPath
from ppaas.planners import create, units, weights
from ppaas.planners.base import PlanRequest
from tests.reference.planners import dijkstra as twin
from tests.support.world import grids


def both(costs, start, goal, **parameters):
    map_ = grids.of(costs)
    request = PlanRequest(grids.centre(map_, *start), grids.centre(map_, *goal))
    return [create(name, **parameters).plan(map_, request) for name in ("dijkstra", "astar")]


def assert_as_cheap(astar, dijkstra):
    """Assert equal costs: each path is the cheapest in its planner's own units, which are finer for A*."""
    assert dijkstra.cost * (1 - 2 * weights.RELATIVE_ERROR) <= astar.cost + 1e-9
    assert astar.cost <= dijkstra.cost * (1 + 2 * units.RELATIVE_ERROR) + 1e-9


@given(grids.cost_arrays(), st.data(), st.booleans())
def test_astar_path_is_as_cheap_with_no_more_settled_cells(costs, data, allow_unknown):
    free = [cell for cell in np.ndindex(costs.shape) if math.isfinite(twin.weight(int(costs[cell]), allow_unknown))]
    assume(free)
    start, goal = data.draw(st.sampled_from(free)), data.draw(st.sampled_from(free))
    try:
        dijkstra, astar = both(costs, start, goal, allow_unknown=allow_unknown)
    except NoValidPath:
        assume(False)
    assert_as_cheap(astar, dijkstra)
    assert astar.expanded <= dijkstra.expanded


@pytest.mark.parametrize("blocked", [0.0, 0.1, 0.3])
@pytest.mark.parametrize("graded", [False, True])
def test_astar_path_is_as_cheap_on_large_maps(blocked, graded):
    rng = np.random.default_rng(11)
    costs = rng.integers(0, 200, (500, 700)).astype(np.uint8) if graded else np.zeros((500, 700), np.uint8)
    costs[rng.random(costs.shape) < blocked] = 254
    costs[:5, :5] = costs[-5:, -5:] = 0
    dijkstra, astar = both(costs, (2, 2), (497, 697))
    assert_as_cheap(astar, dijkstra)
    assert astar.expanded <= dijkstra.expanded


def test_astar_expands_only_its_path_in_free_space():
    _, astar = both(np.zeros((200, 200), np.uint8), (10, 10), (150, 60))
    assert astar.expanded == len(astar.cells) - 1
