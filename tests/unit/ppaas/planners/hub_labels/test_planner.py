"""Hub labels find shortest paths on any map between any cells."""

import math

import numpy as np
import pytest
from hypothesis import given

from ppaas.errors import InvalidPlanner, NoValidPath, PlanCancelled
from ppaas.maps.formats.movingai import parse_map, parse_scenario
from ppaas.planners import create, planner_names
from ppaas.planners.base import PlanRequest
from ppaas.planners.hub_labels.building import assembly
from ppaas.planners.hub_labels.planner import HubLabels
from tests.reference.planners import hub_labels as twin
from tests.support.world import grids
from tests.unit.ppaas.planners.hub_labels.kernels.test_scan import maps


def costmap(free):
    return grids.of(np.where(free, 0, 254).astype(np.uint8))


def assert_all_paths_are_shortest(free, index, starts):
    for start in starts:
        lengths = twin.lengths_from(free, start)
        for goal in np.ndindex(free.shape):
            cells = index.path(*start, *goal)
            if math.isinf(lengths[goal]):
                assert len(cells) == 0
                continue
            assert (tuple(cells[0]), tuple(cells[-1])) == (start, goal)
            assert math.isclose(twin.length_of(free, cells), lengths[goal], rel_tol=1e-6, abs_tol=1e-12)


@given(maps(9))
def test_paths_between_any_cells_are_shortest(free):
    cells = [(int(r), int(c)) for r, c in zip(*np.nonzero(free), strict=True)]
    assert_all_paths_are_shortest(free, HubLabels().prepare(costmap(free)), cells[::3])


@pytest.mark.parametrize("blocked", [0.05, 0.2, 0.4])
def test_paths_on_larger_maps_with_a_core_are_shortest(blocked):
    rng = np.random.default_rng(5)
    free = rng.random((60, 50)) >= blocked
    free[20:40, 20:35] = True
    index = HubLabels().prepare(costmap(free), threads=2)
    cells = [(int(r), int(c)) for r, c in zip(*np.nonzero(free), strict=True)]
    assert_all_paths_are_shortest(free, index, [cells[i] for i in rng.integers(0, len(cells), 3)])


@pytest.mark.parametrize(
    "name", ["dao/arena2", "cities/Boston_0_256", "rooms/32room_003", "mazes/maze512-8-0", "random/random512-35-2"]
)
def test_lengths_equal_those_of_the_scenario(data, name):
    folder = data / "movingai"
    grid = parse_map((folder / f"{name}.map").read_bytes())
    scenario = parse_scenario((folder / f"{name}.map.scen").read_bytes())
    index = HubLabels().prepare(costmap(grid.data == 0), threads=2)
    chosen = np.random.default_rng(1).permutation(len(scenario))[:150]
    for start, goal, optimum in zip(
        *(a[chosen] for a in (scenario.starts, scenario.goals, scenario.optima)), strict=True
    ):
        cells = index.path(*start.tolist(), *goal.tolist())
        assert abs(twin.length_of(grid.data == 0, cells) - optimum) < 0.01
        assert (cells[0].tolist(), cells[-1].tolist()) == (start.tolist(), goal.tolist())


def test_hub_labels_are_installed_and_ignore_graded_costs():
    assert "hub_labels" in planner_names()
    assert "graded costs are ignored" in HubLabels.purpose
    map_ = grids.costmap("""
        ..h..
        .....
    """)
    request = PlanRequest(grids.centre(map_, 1, 0), grids.centre(map_, 1, 4))
    assert create("hub_labels").plan(map_, request).cells.tolist() == [[1, column] for column in range(5)]


def test_blocked_or_outside_ends_have_no_path():
    free = np.ones((4, 5), np.bool_)
    free[1, 1] = False
    index = HubLabels().prepare(costmap(free))
    for ends in (
        (1, 1, 3, 3),
        (3, 3, 1, 1),
        (-1, 0, 2, 2),
        (0, 0, 4, 0),
        (0, 5, 0, 0),
        (0, 0, 0, -1),
        (0, 0, 2**40, 0),
    ):
        assert index.path(*ends).shape == (0, 2)
    assert index.path(2, 3, 2, 3).tolist() == [[2, 3]]
    assert index.path(0, 0, 0, 0).dtype == np.int32


@pytest.mark.parametrize("shape", [(1, 1), (1, 200), (200, 1), (2, 2), (63, 65)])
def test_maps_without_a_corner_need_no_label(shape):
    index = HubLabels().prepare(costmap(np.ones(shape, np.bool_)))
    cells = index.path(0, 0, shape[0] - 1, shape[1] - 1)
    assert len(cells) == max(shape)
    assert index.expanded == 0


def test_fully_blocked_map_has_no_path():
    assert HubLabels().prepare(costmap(np.zeros((5, 5), np.bool_))).path(1, 1, 2, 2).shape == (0, 2)


@pytest.mark.parametrize("transposed", [False, True])
def test_map_may_be_wider_than_the_int16_range(transposed):
    free = np.ones((4, 40_000), np.bool_)
    free[1:3, 100:39_900] = False
    free[1, 20_000:39_000] = True
    free[0, 30_000] = False
    free, ends = (free.T, (0, 0, 39_999, 1)) if transposed else (free, (0, 0, 1, 39_999))
    cells = HubLabels().prepare(costmap(free), threads=2).path(*ends)
    map_ = costmap(free)
    request = PlanRequest(grids.centre(map_, *ends[:2]), grids.centre(map_, *ends[2:]))
    assert twin.length_of(free, cells) == pytest.approx(create("dijkstra").plan(map_, request).cost / 50)


def test_twins_answer_alike_and_share_the_index():
    free = np.random.default_rng(2).random((60, 60)) > 0.2
    free[0, 0] = free[-1, -1] = True
    index = HubLabels().prepare(costmap(free))
    twin_ = index.twin()
    assert twin_.words is index.words
    assert index.nbytes == twin_.nbytes == index.words.nbytes > 0
    np.testing.assert_array_equal(index.path(0, 0, 59, 59), twin_.path(0, 0, 59, 59))
    assert index.expanded == twin_.expanded > 0


def test_index_does_not_depend_on_threads():
    free = np.random.default_rng(7).random((80, 80)) > 0.1
    one, two = (HubLabels().prepare(costmap(free), threads=threads).words for threads in (1, 2))
    np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize("after", [1, 5, 20])
def test_building_can_be_cancelled(after):
    calls = 0

    def check():
        nonlocal calls
        calls += 1
        if calls > after:
            raise PlanCancelled("enough")

    with pytest.raises(PlanCancelled):
        HubLabels().prepare(costmap(np.random.default_rng(7).random((200, 200)) > 0.1), check=check)
    assert calls == after + 1


def test_unreachable_goal_has_no_valid_path():
    map_ = grids.costmap("""
        ..#..
        ..#..
    """)
    with pytest.raises(NoValidPath):
        HubLabels().plan(map_, PlanRequest(grids.centre(map_, 0, 0), grids.centre(map_, 0, 4)))


def test_unknown_cells_are_free_only_if_allowed():
    map_ = grids.costmap(".?.")
    request = PlanRequest(grids.centre(map_, 0, 0), grids.centre(map_, 0, 2))
    assert len(HubLabels().plan(map_, request).cells) == 3
    with pytest.raises(NoValidPath):
        HubLabels(allow_unknown=False).plan(map_, request)


def test_paths_too_long_for_labels_are_refused(monkeypatch):
    monkeypatch.setattr(assembly, "FAR", 500_000)
    free = np.ones((30, 41), np.bool_)
    for column in range(1, 40, 2):
        free[:, column] = False
        free[0 if column % 4 == 1 else -1, column] = True
    with pytest.raises(InvalidPlanner, match="too long"):
        HubLabels().prepare(costmap(free))
