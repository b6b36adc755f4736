"""Paths of straight lines are free, cost what they state, and cost between the optimal lines and the optimal moves."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ppaas.clock import ManualClock
from ppaas.errors import GoalOccupied, NoValidPath, PlanCancelled, PlanTimeout
from ppaas.geometry import Pose2D, yaw_of
from ppaas.maps.formats.movingai import parse_map, parse_scenario
from ppaas.planners import PlanRequest, create
from ppaas.planners.field.cost_field import cost_field
from ppaas.planners.grid.theta_star import ThetaStar, ThetaStarSearch, crossed
from ppaas.planners.watch import proceed
from tests.reference.planners import dijkstra
from tests.reference.planners import dijkstra as moves
from tests.support.world import grids


def plan(costmap, start, goal, name="theta_star", allow_unknown=True, **request):
    ends = grids.centre(costmap, *start), grids.centre(costmap, *goal)
    return create(name, allow_unknown=allow_unknown).plan(costmap, PlanRequest(*ends, **request))


def free_ends(costs, data, allow_unknown=True):
    free = [cell for cell in np.ndindex(costs.shape) if math.isfinite(moves.weight(int(costs[cell]), allow_unknown))]
    assume(free)
    return data.draw(st.sampled_from(free)), data.draw(st.sampled_from(free))


def assert_free_chain(costs, cells, allow_unknown=True):
    """Assert that all cells are free neighbours of the one before, and no diagonal move cuts a corner."""
    for (r, c), (row, column) in itertools.pairwise(map(tuple, cells.tolist())):
        assert max(abs(r - row), abs(c - column)) == 1
        for cell in ((r, c), (row, column), (r, column), (row, c)):
            assert math.isfinite(moves.weight(int(costs[cell]), allow_unknown))


@given(grids.cost_arrays(6), st.data(), st.booleans())
def test_path_is_free_and_never_cheaper_than_the_best_lines(costs, data, allow_unknown):
    start, goal = free_ends(costs, data, allow_unknown)
    least = dijkstra.cheapest(costs, start, goal, allow_unknown)
    map_ = grids.of(costs)
    if math.isinf(least):
        with pytest.raises(NoValidPath, match="clear the costmap"):
            plan(map_, start, goal, allow_unknown=allow_unknown)
        return
    result = plan(map_, start, goal, allow_unknown=allow_unknown)
    assert (tuple(result.cells[0]), tuple(result.cells[-1])) == (start, goal)
    assert_free_chain(costs, result.cells, allow_unknown)
    assert np.array_equal(map_.info.to_cells(result.poses[:, :2]), result.cells)
    assert result.cost >= least * (1 - 1e-9)


@given(grids.cost_arrays(), st.data())
def test_path_cost_agrees_with_the_twin_along_its_lines(costs, data):
    start, goal = free_ends(costs, data)
    field = cost_field(grids.of(costs), cells=goal)
    assume(math.isfinite(field[start]))
    search = ThetaStarSearch(grids.of(costs), field, True, proceed)
    guessed = search.corners(start, goal)
    before = search.cost(guessed)
    corners = search.tautened(guessed)
    rows = [tuple(cell) for cell in search.cells_of(corners).tolist()]
    assert (rows[0], rows[-1]) == (start, goal)
    assert search.cost(corners) == pytest.approx(sum(dijkstra.line(costs, *ends) for ends in itertools.pairwise(rows)))
    assert search.cost(corners) <= before * (1 + 1e-9)
    cells = [cell for ends in itertools.pairwise(rows) for cell, _ in dijkstra.crossed(*ends)[0]]
    assert [tuple(cell) for cell in crossed(search.cells_of(corners))[0].tolist()] == [
        cell for cell, _ in itertools.groupby([rows[0], *cells])
    ]


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.1, 0.2, 0.35]), st.integers(0, 252))
def test_path_on_uniform_costs_is_at_most_as_long_as_dijkstras(seed, blocked, cost):
    rng = np.random.default_rng(seed)
    costs = np.where(rng.random(rng.integers(1, 60, 2)) < blocked, 254, cost).astype(np.uint8)
    free = np.argwhere(costs < 253)
    assume(len(free))
    start, goal = (tuple(cell) for cell in free[rng.integers(len(free), size=2)].tolist())
    map_ = grids.of(costs)
    try:
        dijkstra = plan(map_, start, goal, "dijkstra")
    except NoValidPath:
        assume(False)
    result = plan(map_, start, goal)
    assert result.cost <= dijkstra.cost * (1 + 1e-9)
    assert result.cost >= (50 + 0.8 * cost) * math.dist(start, goal) * (1 - 1e-9)
    assert result.cost == pytest.approx((50 + 0.8 * cost) * result.length)


@pytest.mark.parametrize(("graded", "most"), [(False, 1.008), (True, 1.01)])
def test_path_on_small_maps_is_close_to_the_best_lines(graded, most):
    rng = np.random.default_rng(2)
    ratios = []
    while len(ratios) < 40:
        costs = rng.integers(0, 253 if graded else 1, (8, 8)).astype(np.uint8)
        costs[rng.random(costs.shape) < 0.2] = 254
        start, goal = (tuple(cell) for cell in rng.permutation(np.argwhere(costs < 253))[:2].tolist())
        least = dijkstra.cheapest(costs, start, goal)
        if math.isfinite(least):
            ratios.append(plan(grids.of(costs), start, goal).cost / least)
    assert np.mean(ratios) < most


@pytest.mark.parametrize("name", ["dao/arena2", "mazes/maze512-8-0", "random/random512-35-2"])
def test_paths_on_real_maps_are_shorter_than_grid_paths(data, name):
    file = data / "movingai" / f"{name}.map"
    grid, queries = parse_map(file.read_bytes()), parse_scenario(file.with_suffix(".map.scen").read_bytes())
    map_ = grids.of(np.where(grid.data == 0, 0, 254).astype(np.uint8))
    ratios = []
    for at in np.linspace(20, len(queries) - 1, 12).astype(int):
        result = plan(map_, queries.starts[at], queries.goals[at])
        assert_free_chain(map_.data, result.cells)
        ratios.append(result.cost / 50 / queries.optima[at])
        assert result.length >= math.dist(queries.starts[at], queries.goals[at]) - 1e-6
    assert max(ratios) < 1 + 1e-4  # the file rounds its optima
    assert np.mean(ratios) < 0.98


def test_path_in_free_space_is_one_line_with_a_pose_per_cell():
    map_ = grids.of(np.zeros((40, 90), np.uint8), 0.1)
    result = plan(map_, (3, 4), (34, 81))
    assert result.cost == pytest.approx(50 * math.hypot(31, 77))
    assert result.length == pytest.approx(0.1 * math.hypot(31, 77))
    assert len(result.poses) == len(result.cells) == 31 + 77  # one corner of four cells in the middle
    yaws = [yaw_of(*pose[3:]) for pose in result.poses.tolist()]
    assert yaws[1:-2] == pytest.approx([math.atan2(31, 77)] * (len(yaws) - 3))


def test_path_detours_around_high_costs():
    map_ = grids.costmap(".......\n..hhh..\n..hhh..\n.......\n.......")
    assert not map_.data[tuple(plan(map_, (2, 0), (2, 6)).cells.T)].any()


def test_no_line_passes_between_diagonal_obstacles():
    with pytest.raises(NoValidPath):
        plan(grids.costmap("..#..\n..#..\n.#...\n.#..."), (0, 0), (0, 4))


def test_unknown_cells_are_crossed_only_if_allowed():
    map_ = grids.costmap(".?.")
    assert plan(map_, (0, 0), (0, 2)).cost == 50.0 + 253.0
    with pytest.raises(NoValidPath):
        plan(map_, (0, 0), (0, 2), allow_unknown=False)


def test_start_equal_to_the_goal_gives_one_cell_at_no_cost():
    result = plan(grids.costmap("."), (0, 0), (0, 0))
    assert result.cells.tolist() == [[0, 0]]
    assert (result.cost, result.length, len(result.poses)) == (0.0, 0.0, 1)


def test_a_row_of_8192_cells_is_one_line():
    result = plan(grids.of(np.full((1, 8_192), 252, np.uint8)), (0, 8_191), (0, 0))
    assert result.cells[:, 1].tolist() == list(range(8_191, -1, -1))
    assert result.cost == pytest.approx(8_191 * 251.6)


def test_poses_begin_and_end_at_the_requested_poses():
    map_ = grids.costmap("....\n....\n....", resolution=0.5)
    result = ThetaStar().plan(map_, PlanRequest(Pose2D(0.1, 0.2, 2.0), Pose2D(1.9, 1.4, -1.0)))
    assert result.poses[0, :2].tolist() == [0.1, 0.2]
    assert result.poses[-1, :2].tolist() == [1.9, 1.4]
    assert yaw_of(*result.poses[0, 3:]) == pytest.approx(2.0)
    assert yaw_of(*result.poses[-1, 3:]) == pytest.approx(-1.0)
    assert result.planner == "theta_star"


def test_path_first_leaves_inscribed_cells():
    map_ = grids.costmap("#iii....\n" * 3, resolution=0.1)
    result = plan(map_, (1, 1), (2, 7))
    assert result.cells[:3].tolist() == [[1, 1], [1, 2], [1, 3]]
    assert len(result.poses) == len(result.cells)
    assert result.cost == pytest.approx(3 * (50 + 0.8 * 253) + 50 * math.hypot(1, 3))


def test_goal_in_a_wall_is_moved_to_the_nearest_free_cell():
    map_ = grids.costmap("....##", resolution=0.1)
    assert plan(map_, (0, 0), (0, 5), tolerance=0.21).cells[-1].tolist() == [0, 3]
    with pytest.raises(GoalOccupied):
        plan(map_, (0, 0), (0, 5), tolerance=0.19)


def test_all_thread_counts_give_the_same_path():
    rng = np.random.default_rng(4)
    costs = np.where(rng.random((300, 300)) < 0.3, 254, rng.integers(0, 3, (300, 300)) * 60).astype(np.uint8)
    costs[:3, :3] = costs[-3:, -3:] = 0
    one, two = (plan(grids.of(costs), (1, 1), (298, 298), threads=threads) for threads in (1, 2))
    assert np.array_equal(one.poses, two.poses)


def _checks_of_a_whole_plan(map_):
    checks = 0

    def cancelled():
        nonlocal checks
        checks += 1
        return False

    plan(map_, (1, 1), (298, 298), cancelled=cancelled)
    return checks


def test_cancelled_plan_ends_at_the_next_check():
    rng = np.random.default_rng(4)
    costs = np.where(rng.random((300, 300)) < 0.3, 254, 0).astype(np.uint8)
    costs[:3, :3] = costs[-3:, -3:] = 0
    map_ = grids.of(costs)
    whole = _checks_of_a_whole_plan(map_)
    for most in range(0, whole, max(1, whole // 20)):
        checks = itertools.count()
        with pytest.raises(PlanCancelled):
            plan(map_, (1, 1), (298, 298), cancelled=lambda checks=checks, most=most: next(checks) >= most)
        assert next(checks) == most + 1


def test_deadline_ends_the_plan():
    clock = ManualClock()

    def tick():
        clock.advance(0.25)
        return clock()

    with pytest.raises(PlanTimeout, match=r"1\.0 s"):
        plan(grids.of(np.zeros((99, 99), np.uint8)), (0, 0), (98, 98), clock=tick, timeout=1.0)


def test_costmap_is_not_modified():
    data = np.random.default_rng(1).integers(0, 253, (50, 50)).astype(np.uint8)
    before = data.copy()
    data.flags.writeable = False
    plan(grids.of(data), (0, 0), (49, 49), threads=2)
    assert np.array_equal(data, before)
