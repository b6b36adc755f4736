"""Common behaviour of A* and jump point search: prepared maps, integer weights, successive searches."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.costmap.costmap import Costmap
from ppaas.maps.formats.movingai import parse_map, parse_scenario
from ppaas.maps.grid import FREE
from ppaas.planners.base import PlanRequest
from ppaas.planners.grid import astar as astar_search
from ppaas.planners.grid import jps as jump_search
from ppaas.planners.grid import search_memory
from ppaas.planners.grid.astar import AStar
from ppaas.planners.grid.dijkstra import Dijkstra
from ppaas.planners.grid.jps import JumpPointSearch
from ppaas.planners.grid.kernels import astar, jps, jump_planes, padding
from tests.reference.planners import jumps as twin
from tests.support.world import grids

KINDS = pytest.mark.parametrize("kind", [AStar, JumpPointSearch], ids=["astar", "jps"])
COSTS = [
    [0, 0, 0, 0, 254],
    [0, 0, 0, 0, 0, 0, 100, 254, 255],
    [0, 0, 1, 2, 128, 252, 253, 254, 255],
]
"""Kinds of costs: uniform; uniform areas with few exceptions; graded."""


@st.composite
def scenes(draw, most=14):
    """Draw costs, in which patches of one cost are common, and a few free cells."""
    values = np.array(draw(st.sampled_from(COSTS)), np.uint8)
    height, width = draw(st.integers(1, most)), draw(st.integers(1, most))
    rng = np.random.default_rng(draw(st.integers(0, 1 << 32)))
    costs = rng.choice(values, (height, width))
    for _ in range(draw(st.integers(0, 3))):
        row, column = rng.integers(height), rng.integers(width)
        costs[row : row + rng.integers(1, 7), column : column + rng.integers(1, 7)] = rng.choice(values)
    free = [cell for cell in np.ndindex(costs.shape) if costs[cell] < 253]
    if not free:
        costs[0, 0], free = 0, [(0, 0)]
    cells = st.sampled_from(free)
    return costs, draw(st.lists(st.tuples(cells, cells), min_size=1, max_size=4))


def assert_cheapest(costs, path, start, goal, allow_unknown=True):
    values = twin.unit_values(costs, goal, allow_unknown)
    if start not in values:
        assert path.shape == (0, 2)
        return
    assert path.dtype == np.int32
    assert (tuple(path[0]), tuple(path[-1])) == (start, goal)
    for (row, column), (r, c) in itertools.pairwise(path.tolist()):
        assert max(abs(row - r), abs(column - c)) == 1
        assert {(row, column), (r, c), (row, c), (r, column)} <= values.keys()
    assert twin.unit_cost(costs, path, allow_unknown) == values[start]


@KINDS
@given(scenes(), st.booleans())
def test_successive_searches_agree_with_the_twin(kind, scene, allow_unknown):
    costs, queries = scene
    prepared = kind(allow_unknown=allow_unknown).prepare(grids.of(costs))
    for start, goal in queries:
        if math.isfinite(twin.weight(int(costs[start]), allow_unknown)):
            assert_cheapest(costs, prepared.path(*start, *goal), start, goal, allow_unknown)


@KINDS
@given(scenes())
def test_slices_of_one_cell_and_small_capacities_give_the_same_paths(kind, scene):
    costs, queries = scene
    whole = kind().prepare(grids.of(costs))
    with pytest.MonkeyPatch.context() as patch:
        for name in ("SLICE_CELLS", "SLICE_WALKED"):
            patch.setattr(astar_search, name, 1)
        for name in ("SLICE_WORK", "SLICE_UNWOUND"):
            patch.setattr(jump_search, name, 1)
        patch.setattr(jump_search, "FIRST_CELLS", 1)
        patch.setattr(search_memory, "INITIAL_CAPACITY", 1)
        patch.setattr(search_memory, "LOWEST", -1)
        sliced = kind().prepare(grids.of(costs))
        for query in queries:
            path = sliced.path(*query[0], *query[1])
            assert np.array_equal(path, whole.path(*query[0], *query[1]))
            assert sliced.expanded == whole.expanded


def test_kernels_are_compiled_once_for_maps_of_every_kind():
    read_only, graded = np.zeros((3, 4), np.uint8), np.array([[0, 7], [9, 254]], np.uint8)
    read_only.flags.writeable = False
    for module in (padding, astar, jump_planes, jps):
        module.warm()
    kernels = astar.aim, astar.walk, jps.jump, jps.unwind, jump_planes.mark_cells, jump_planes.mark_jumps
    compiled = [len(kernel.signatures) for kernel in (*kernels, padding.pad)]
    for kind, costs in itertools.product((AStar, JumpPointSearch), (read_only, graded)):
        assert len(kind().prepare(grids.of(costs)).path(0, 0, 0, 1)) == 2
    assert [len(kernel.signatures) for kernel in (*kernels, padding.pad)] == compiled == [1] * 6 + [2]


@KINDS
def test_an_interrupted_search_does_not_affect_the_next(kind, monkeypatch):
    monkeypatch.setattr(astar_search, "SLICE_CELLS", 1_000)
    monkeypatch.setattr(jump_search, "SLICE_WORK", 1_000)
    rng = np.random.default_rng(2)
    costs = rng.choice(np.array([0, 0, 0, 9, 254], np.uint8), (300, 300))
    costs[:2, :2] = costs[-2:, -2:] = 0
    prepared, fresh = (kind().prepare(grids.of(costs)) for _ in range(2))
    cancels = iter([False, True])

    def check():
        if next(cancels):
            raise TimeoutError

    with pytest.raises(TimeoutError):
        prepared.path(0, 0, 299, 299, check)
    assert np.array_equal(prepared.path(299, 0, 0, 299), fresh.path(299, 0, 0, 299))


@KINDS
def test_twin_shares_the_map_and_searches_independently(kind):
    rng = np.random.default_rng(4)
    costs = rng.choice(np.array([0, 0, 0, 254], np.uint8), (60, 80))
    costs[0, 0] = costs[59, 79] = 0
    one = kind().prepare(grids.of(costs))
    other = one.twin()
    assert other._map is one._map
    before = one.path(0, 0, 59, 79)
    other.path(59, 79, 0, 0)
    assert np.array_equal(one.path(0, 0, 59, 79), before)
    assert one.nbytes == other.nbytes > costs.size


@KINDS
def test_diagonal_longer_than_the_longest_jump_is_complete(kind):
    prepared = kind().prepare(grids.of(np.zeros((2_500, 2_600), np.uint8)))
    path = prepared.path(0, 0, 2_499, 2_599)
    diagonal = np.abs(np.diff(path, axis=0)).sum(axis=1) == 2
    assert (len(path), diagonal.sum()) == (2_600, 2_499)


@pytest.mark.parametrize("writable", [False, True], ids=["read-only", "writable"])
def test_a_cost_field_takes_over_jumps_on_a_large_map_with_many_corners(writable):
    rng = np.random.default_rng(5)
    costs = rng.choice(np.array([0] * 9 + [254], np.uint8), (700, 800))
    costs[:2, :2] = costs[-2:, -2:] = 0
    costs.flags.writeable = writable
    map_ = grids.of(costs)
    planned = [kind().plan(map_, between(map_, (0, 0), (699, 799))) for kind in (JumpPointSearch, Dijkstra)]
    assert planned[0].planner == "jps"
    assert planned[0].expanded == planned[1].expanded
    assert np.array_equal(planned[0].cells, planned[1].cells)


def test_jumps_are_tried_again_where_a_cost_field_took_over():
    rng = np.random.default_rng(6)
    costs = rng.choice(np.array([0] * 9 + [254], np.uint8), (700, 800))
    costs[:2, :2] = costs[-2:, -2:] = costs[:20, :20] = 0
    prepared = JumpPointSearch().prepare(grids.of(costs))
    queries = [((0, 0), (10, 15)), ((0, 0), (699, 799)), ((0, 0), (10, 15)), ((0, 0), (699, 799))]
    taken_over = []
    for start, goal in queries:
        assert_cheapest_by_field(costs, prepared.path(*start, *goal), start, goal)
        taken_over.append(prepared.taken_over)
    assert taken_over == [False, True, False, True]


def test_a_cost_field_reports_that_there_is_no_path():
    rng = np.random.default_rng(7)
    costs = rng.choice(np.array([0] * 9 + [254], np.uint8), (700, 800))
    costs[:3, :3] = 254
    costs[0, 0] = costs[-1, -1] = 0
    assert JumpPointSearch().prepare(grids.of(costs)).path(699, 799, 0, 0).shape == (0, 2)


def between(map_, start, goal):
    return PlanRequest(grids.centre(map_, *start), grids.centre(map_, *goal))


def assert_cheapest_by_field(costs, path, start, goal):
    """Assert that a path costs the same as the path of ``dijkstra``; the twin would take minutes."""
    field = Dijkstra().plan(grids.of(costs), between(grids.of(costs), start, goal))
    assert (tuple(path[0]), tuple(path[-1])) == (start, goal)
    assert twin.unit_cost(costs, path, True) == twin.unit_cost(costs, field.cells, True)


@KINDS
@pytest.mark.parametrize("shape", [(1, 32_768), (32_768, 1), (3, 32_768)])
def test_map_side_may_have_32768_cells(kind, shape):
    costs = np.zeros(shape, np.uint8)
    costs[1:2, 1::3] = 254 if shape[0] == 3 else 0
    end = shape[0] - 1, shape[1] - 1
    path = kind().prepare(grids.of(costs)).path(0, 0, *end)
    assert len(path) >= 32_768
    assert (tuple(path[0]), tuple(path[-1])) == ((0, 0), end)


@KINDS
def test_lengths_on_movingai_maps_equal_those_of_the_scenarios(kind, data):
    for file in sorted((data / "movingai").glob("*/*.map")):
        map_ = parse_map(file.read_bytes())
        scenario = parse_scenario(file.with_suffix(".map.scen").read_bytes())
        costs = np.where(map_.data == FREE, 0, 254).astype(np.uint8)
        prepared = kind().prepare(Costmap(costs, map_.info))
        for query in np.linspace(0, len(scenario) - 1, 8).astype(int):
            path = prepared.path(*scenario.starts[query].tolist(), *scenario.goals[query].tolist())
            diagonals = int((np.abs(np.diff(path, axis=0)).sum(axis=1) == 2).sum())
            length = len(path) - 1 - diagonals + diagonals * math.sqrt(2.0)
            assert length == pytest.approx(scenario.optima[query], abs=0.01), (file.name, query)
