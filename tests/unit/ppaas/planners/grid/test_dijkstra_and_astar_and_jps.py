import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ppaas.clock import ManualClock
from ppaas.errors import (
    GoalOccupied,
    GoalOutsideMap,
    InvalidInput,
    NoValidPath,
    PlanCancelled,
    PlanTimeout,
    StartOccupied,
    StartOutsideMap,
)
from ppaas.geometry import Pose2D, yaw_of
from ppaas.planners import create, units, weights
from ppaas.planners.base import PlanRequest
from ppaas.planners.field import tile_field
from ppaas.planners.grid.astar import AStar
from ppaas.planners.grid.dijkstra import Dijkstra
from ppaas.planners.grid.jps import JumpPointSearch
from ppaas.planners.weights import RELATIVE_ERROR
from tests.reference.planners import dijkstra as twin
from tests.support.world import grids

ENCLOSED = np.zeros((1_500, 1_500), np.uint8)
ENCLOSED[:2, :2] = 254
ENCLOSED[0, 0] = 0
"""A map without a path to (0, 0), on which all other cells are expanded."""


@pytest.fixture(scope="module", params=[Dijkstra, AStar, JumpPointSearch], ids=["dijkstra", "astar", "jps"])
def kind(request):
    """Return each of the planners: all tests run with each."""
    return request.param


@pytest.fixture(scope="module")
def plan(kind):
    """Return a call that plans from cell to cell."""

    def planned(costmap, start, goal, allow_unknown=True, **request):
        ends = grids.centre(costmap, *start), grids.centre(costmap, *goal)
        return kind(allow_unknown=allow_unknown).plan(costmap, PlanRequest(*ends, **request))

    return planned


def assert_walkable(costmap, cells, allow_unknown=True):
    """Assert that all cells are free, all moves go to neighbours, and no diagonal move cuts a corner."""

    def free(cell):
        return math.isfinite(twin.weight(int(costmap.data[cell]), allow_unknown))

    path = [tuple(cell) for cell in cells.tolist()]
    assert all(free(cell) for cell in path)
    for (r, c), (row, column) in itertools.pairwise(path):
        assert max(abs(r - row), abs(c - column)) == 1
        assert free((r, column))
        assert free((row, c))


@given(grids.cost_arrays(), st.data(), st.booleans())
def test_path_is_walkable_and_as_cheap_as_the_twins(plan, costs, data, allow_unknown):
    free = [cell for cell in np.ndindex(costs.shape) if math.isfinite(twin.weight(int(costs[cell]), allow_unknown))]
    assume(free)
    start, goal = data.draw(st.sampled_from(free)), data.draw(st.sampled_from(free))
    map_ = grids.of(costs)
    least = twin.cost_field(costs, [goal], allow_unknown)[start]
    if math.isinf(least):
        with pytest.raises(NoValidPath, match="clear the costmap"):
            plan(map_, start, goal, allow_unknown)
        return
    result = plan(map_, start, goal, allow_unknown)
    assert_walkable(map_, result.cells, allow_unknown)
    assert (tuple(result.cells[0]), tuple(result.cells[-1])) == (start, goal)
    assert least - 1e-9 <= result.cost <= least * (1 + 2 * RELATIVE_ERROR) + 1e-9


def test_poses_begin_and_end_at_the_requested_poses(plan, kind):
    map_ = grids.costmap("....\n....\n....", resolution=0.5)
    start, goal = Pose2D(0.1, 0.2, 2.0), Pose2D(1.9, 0.4, -1.0)
    result = kind().plan(map_, PlanRequest(start, goal))
    assert result.poses[0, :2].tolist() == [0.1, 0.2]
    assert result.poses[-1, :2].tolist() == [1.9, 0.4]
    assert yaw_of(*result.poses[0, 3:]) == pytest.approx(2.0)
    assert yaw_of(*result.poses[-1, 3:]) == pytest.approx(-1.0)
    assert result.cells.dtype == np.int32
    assert len(result.poses) == len(result.cells) == 4
    assert result.cost == 3 * 50.0
    steps = np.diff(result.poses[:, :2], axis=0)
    assert result.length == pytest.approx(np.hypot(*steps.T).sum())
    assert result.planner == kind.name


def test_turned_and_shifted_map_gives_the_same_cells(plan):
    rng = np.random.default_rng(3)
    costs = rng.integers(0, 253, (40, 30)).astype(np.uint8)
    straight, turned = grids.of(costs, 0.05), grids.of(costs, 0.05, Pose2D(-3.0, 7.0, 2.1))
    paths = [plan(map_, (2, 3), (37, 28)) for map_ in (straight, turned)]
    assert np.array_equal(paths[0].cells, paths[1].cells)
    np.testing.assert_allclose(turned.info.to_world(paths[1].cells), paths[1].poses[:, :2], atol=1e-9)
    assert paths[0].length == pytest.approx(paths[1].length)


def test_start_equal_to_the_goal_gives_one_cell_at_no_cost(plan):
    result = plan(grids.costmap("."), (0, 0), (0, 0))
    assert result.cells.tolist() == [[0, 0]]
    assert (result.cost, result.length, len(result.poses)) == (0.0, 0.0, 1)


def test_start_and_goal_in_one_cell_give_the_goal_pose(plan, kind):
    result = kind().plan(grids.costmap(".."), PlanRequest(Pose2D(0.2, 0.2), Pose2D(0.7, 0.6, 1.0)))
    assert result.poses[:, :2].tolist() == [[0.7, 0.6]]
    assert yaw_of(*result.poses[0, 3:]) == pytest.approx(1.0)


@pytest.mark.parametrize("shape", [(1, 9), (9, 1)])
def test_corridor_one_cell_wide_is_traversed_straight(plan, shape):
    result = plan(grids.of(np.full(shape, 100, np.uint8)), (0, 0), (shape[0] - 1, shape[1] - 1))
    assert len(result.cells) == 9
    assert result.cost == 8 * 130.0


def test_row_of_32768_cells_at_the_highest_cost_is_traversed(plan):
    result = plan(grids.of(np.full((1, 32_768), 252, np.uint8)), (0, 32_767), (0, 0))
    assert result.cells[:, 1].tolist() == list(range(32_767, -1, -1))
    assert result.cost == pytest.approx(32_767 * 251.6)


def test_no_path_passes_between_diagonal_obstacles(plan):
    with pytest.raises(NoValidPath):
        plan(grids.costmap(".#\n#."), (0, 1), (1, 0))


def test_path_detours_around_high_costs(plan):
    assert [1, 1] not in plan(grids.costmap("...\n.h.\n.h."), (0, 0), (0, 2)).cells.tolist()


def test_path_with_few_turns_is_preferred_among_equal_costs(plan):
    moves = np.diff(plan(grids.of(np.zeros((9, 30), np.uint8)), (1, 1), (6, 25)).cells, axis=0)
    assert np.any(np.diff(moves, axis=0) != 0, axis=1).sum() == 1


def test_unknown_cells_are_entered_only_if_allowed(plan):
    map_ = grids.costmap(".?.")
    assert plan(map_, (0, 0), (0, 2)).cost == 50.0 + 253.0
    with pytest.raises(NoValidPath):
        plan(map_, (0, 0), (0, 2), allow_unknown=False)


def test_path_first_leaves_inscribed_cells(plan):
    map_ = grids.costmap("#iii....\n" * 3, resolution=0.1)
    result = plan(map_, (1, 1), (1, 7))
    assert result.cells.tolist() == [[1, c] for c in range(1, 8)]
    assert result.cost == pytest.approx(3 * (50 + 0.8 * 253) + 3 * 50.0)


def test_goal_in_a_wall_is_moved_to_the_nearest_free_cell(plan):
    map_ = grids.costmap("....##", resolution=0.1)
    result = plan(map_, (0, 0), (0, 5), tolerance=0.21)
    assert result.cells[-1].tolist() == [0, 3]
    np.testing.assert_allclose(result.poses[-1, :2], map_.info.to_world((0, 3)))
    with pytest.raises(GoalOccupied, match=r"x=0.550 y=0.050.*tolerance"):
        plan(map_, (0, 0), (0, 5), tolerance=0.19)


@pytest.mark.parametrize(
    ("start", "goal", "error", "text"),
    [
        (Pose2D(-1.0, 0.5), Pose2D(0.5, 0.5), StartOutsideMap, "x=-1.000 y=0.500"),
        (Pose2D(0.5, 0.5), Pose2D(9.0, 0.5), GoalOutsideMap, "x=9.000 y=0.500"),
        (Pose2D(1.5, 0.5), Pose2D(0.5, 0.5), StartOccupied, "x=1.500 y=0.500"),
        (Pose2D(0.5, 0.5), Pose2D(1.5, 0.5), GoalOccupied, "x=1.500 y=0.500"),
        (Pose2D(0.5, 0.5), Pose2D(2.5, 0.5), NoValidPath, "x=2.500 y=0.500"),
        (Pose2D(math.nan, 0.5), Pose2D(2.5, 0.5), InvalidInput, "start"),
        (Pose2D(0.5, 0.5), Pose2D(0.5, math.inf), InvalidInput, "goal"),
    ],
)
def test_each_failure_has_its_error_type_and_position(plan, kind, start, goal, error, text):
    with pytest.raises(error, match=text):
        kind().plan(grids.costmap(".#."), PlanRequest(start, goal))


@pytest.mark.parametrize(
    "wrong", [{"tolerance": -0.1}, {"tolerance": math.nan}, {"timeout": -1.0}, {"timeout": math.nan}, {"threads": 0}]
)
def test_an_invalid_request_is_refused(plan, wrong):
    with pytest.raises(InvalidInput):
        plan(grids.costmap(".."), (0, 0), (0, 1), **wrong)


@pytest.mark.parametrize("checks", [0, 1, 5, 20])
def test_cancelled_plan_ends_at_the_next_check(plan, checks, monkeypatch):
    monkeypatch.setattr(tile_field, "SLICE_LINES", 1)
    count = 0

    def cancelled():
        nonlocal count
        count += 1
        return count > checks

    with pytest.raises(PlanCancelled):
        plan(grids.of(ENCLOSED), (0, 0), (1_499, 1_499), cancelled=cancelled)
    assert count == checks + 1


def test_deadline_ends_the_plan_and_is_stated_in_the_error(plan, monkeypatch):
    monkeypatch.setattr(tile_field, "SLICE_LINES", 1)
    clock = ManualClock(100.0)

    def tick():
        clock.advance(0.25)
        return clock()

    with pytest.raises(PlanTimeout, match=r"2\.0 s"):
        plan(grids.of(ENCLOSED), (0, 0), (1_499, 1_499), clock=tick, timeout=2.0)
    assert clock() == 102.25


def test_planning_time_is_measured_by_the_requests_clock(plan):
    clock = ManualClock()

    def tick():
        clock.advance(0.5)
        return clock()

    result = plan(grids.costmap("...."), (0, 0), (0, 3), clock=tick)
    assert result.seconds == clock() - 0.5


def test_search_stops_at_the_goal(plan, kind):
    result = plan(grids.of(np.zeros((600, 600), np.uint8)), (300, 300), (300, 330))
    assert (1 if kind is JumpPointSearch else 30) <= result.expanded < 4_500


def test_costmap_is_not_modified(plan):
    data = np.random.default_rng(1).integers(0, 253, (50, 50)).astype(np.uint8)
    before = data.copy()
    data.flags.writeable = False
    plan(grids.of(data), (0, 0), (49, 49), threads=2)
    assert np.array_equal(data, before)


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
