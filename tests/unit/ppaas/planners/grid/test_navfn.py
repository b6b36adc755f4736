import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ppaas.costmap.costmap import Costmap
from ppaas.errors import GoalOccupied, InvalidPlanner, NoValidPath, PlanCancelled, PlanTimeout
from ppaas.geometry import Pose2D, yaw_of
from ppaas.maps.formats.movingai import parse_map, parse_scenario
from ppaas.planners import PlanRequest, create
from ppaas.planners.grid import navfn as module
from ppaas.planners.grid.navfn import NavFn, NavigationFunction
from tests.reference.planners import dijkstra as exact
from tests.reference.planners import navfn as twin
from tests.support.world import grids


@st.composite
def scenes(draw):
    costs, allow_unknown = draw(grids.cost_arrays()), draw(st.booleans())
    free = [cell for cell in np.ndindex(costs.shape) if twin.weight(int(costs[cell]), allow_unknown) is not None]
    assume(free)
    return costs, draw(st.sampled_from(free)), draw(st.sampled_from(free)), allow_unknown


def plan(costmap, start, goal, *, allow_unknown=True, use_astar=False, **request):
    ends = grids.centre(costmap, *start), grids.centre(costmap, *goal)
    planner = NavFn(allow_unknown=allow_unknown, use_astar=use_astar)
    return planner.plan(costmap, PlanRequest(*ends, **request))


def steps_inside(cells, points):
    """Return the cells that the straight lines between points cross, sampled every fiftieth of a cell."""
    inside = set()
    for one, other in itertools.pairwise(points):
        for part in np.linspace(0.0, 1.0, 60):
            place = (1.0 - part) * np.array(one) + part * np.array(other)
            inside.add(tuple(np.floor(place + 0.5).astype(int).tolist()))
    return inside


@given(scenes(), st.sampled_from(["all", "start", "astar"]))
def test_potentials_agree_with_the_twin(scene, until):
    costs, start, goal, allow_unknown = scene
    target = None if until == "all" else start
    function = NavigationFunction(grids.of(costs), goal, allow_unknown=allow_unknown)
    reached = function.grow(target, astar=until == "astar")
    slow = twin.potentials(costs, goal, target, allow_unknown=allow_unknown, astar=until == "astar")
    np.testing.assert_allclose(function.potentials(), slow, rtol=1e-6)
    assert function.reached == np.isfinite(slow).sum()
    assert reached == (target is None or bool(np.isfinite(slow[start])))


@given(scenes(), st.booleans(), st.sampled_from([1, 3, 20_000]))
def test_path_walk_agrees_with_the_twin_in_slices_of_any_length(scene, early, slice_steps):
    costs, start, goal, allow_unknown = scene
    function = NavigationFunction(grids.of(costs), goal, allow_unknown=allow_unknown)
    assume(function.grow(start if early else None) and np.isfinite(function.potentials()[start]))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "SLICE_STEPS", slice_steps)
        cells, points = function.walk_from(start)
    slow_cells, slow_points = twin.walk(function.potentials(), start, goal)
    np.testing.assert_allclose(points, slow_points, atol=1e-9)
    if slice_steps == 20_000:
        assert cells.tolist() == [list(cell) for cell in slow_cells]


@given(scenes(), st.booleans())
def test_path_connects_its_ends_through_free_cells(scene, use_astar):
    costs, start, goal, allow_unknown = scene
    map_ = grids.of(costs)
    best = exact.cost_field(costs, [goal], allow_unknown)[start]
    if math.isinf(best):
        with pytest.raises(NoValidPath):
            plan(map_, start, goal, allow_unknown=allow_unknown, use_astar=use_astar)
        return
    result = plan(map_, start, goal, allow_unknown=allow_unknown, use_astar=use_astar)
    free = {cell for cell in np.ndindex(costs.shape) if twin.weight(int(costs[cell]), allow_unknown) is not None}
    path = [tuple(cell) for cell in result.cells.tolist()]
    assert (path[0], path[-1]) == (start, goal)
    for (r, c), (row, column) in itertools.pairwise(path):
        assert max(abs(r - row), abs(c - column)) == 1
        assert {(r, c), (row, column), (r, column), (row, c)} <= free
    points = result.poses[:, [1, 0]] - 0.5
    assert steps_inside(path, points) <= free
    assert (points[0].round(9).tolist(), points[-1].round(9).tolist()) == (list(start), list(goal))
    assert result.cost >= best - 1e-9


def test_potentials_in_free_space_approximate_euclidean_distance():
    function = NavigationFunction(grids.of(np.zeros((121, 121), np.uint8)), (60, 60))
    function.grow()
    straight = np.hypot(*(np.indices((121, 121)) - 60))
    cells = function.potentials() / 50.0
    assert (cells >= straight - 0.01).all()
    assert (cells <= 1.03 * straight + 1.0).all()


@pytest.mark.parametrize("use_astar", [False, True])
def test_path_in_free_space_is_straight(use_astar):
    result = plan(grids.of(np.zeros((60, 90), np.uint8)), (5, 5), (50, 80), use_astar=use_astar)
    assert result.length == pytest.approx(math.hypot(45, 75), rel=0.01)
    steps = np.hypot(*np.diff(result.poses[:, :2], axis=0).T)
    assert np.median(steps) == pytest.approx(0.5)
    assert steps.max() <= math.sqrt(2.0) + 1e-9


@pytest.mark.parametrize("name", ["dao/arena2", "mazes/maze512-1-3", "random/random512-35-2", "rooms/32room_003"])
def test_paths_on_real_maps_are_nearly_shortest(data, name):
    file = data / "movingai" / f"{name}.map"
    grid = parse_map(file.read_bytes())
    map_ = Costmap(np.where(grid.data > 0, 254, 0).astype(np.uint8), grid.info)
    scenario = parse_scenario(file.with_suffix(".map.scen").read_bytes())
    for query in np.linspace(0, len(scenario) - 1, 8).astype(int):
        ends = tuple(scenario.starts[query]), tuple(scenario.goals[query])
        result = plan(map_, *ends, use_astar=bool(query % 2))
        best = scenario.optima[query]
        assert 0.92 * best - 1e-6 <= result.length <= 1.1 * best + 1e-6
        assert best - 0.01 <= result.cost / 50.0 <= 1.2 * best + 1e-6


def test_astar_reaches_fewer_cells():
    map_ = grids.of(np.zeros((300, 300), np.uint8))
    wide, narrow = (plan(map_, (150, 10), (150, 200), use_astar=use_astar) for use_astar in (False, True))
    assert narrow.expanded < 0.6 * wide.expanded


def test_poses_end_at_the_requested_poses_on_a_turned_map():
    map_ = grids.of(np.zeros((20, 30), np.uint8), 0.1, Pose2D(3.0, -2.0, 0.7))
    start, goal = Pose2D(*map_.info.to_world((2.3, 3.2)), 1.0), Pose2D(*map_.info.to_world((15.6, 20.1)), -2.0)
    result = NavFn().plan(map_, PlanRequest(start, goal))
    assert result.poses[0, :2].tolist() == [start.x, start.y]
    assert result.poses[-1, :2].tolist() == [goal.x, goal.y]
    assert yaw_of(*result.poses[-1, 3:]) == pytest.approx(-2.0)
    assert result.planner == "navfn"


def test_start_equal_to_the_goal_gives_one_cell():
    result = plan(grids.costmap("."), (0, 0), (0, 0))
    assert result.cells.tolist() == [[0, 0]]
    assert (result.cost, len(result.poses)) == (0.0, 1)


@pytest.mark.parametrize("shape", [(1, 40), (40, 1)])
def test_corridor_along_the_map_edge_is_traversed(shape):
    result = plan(grids.of(np.full(shape, 10, np.uint8)), (0, 0), (shape[0] - 1, shape[1] - 1))
    assert len(result.cells) == 40
    assert result.cost == pytest.approx(39 * 58.0)


def test_maze_with_many_turns_is_traversed():
    costs = np.zeros((201, 201), np.uint8)
    costs[1::2] = 254
    costs[1::4, -1] = 0
    costs[3::4, 0] = 0
    result = plan(grids.of(costs), (0, 0), (200, 200))
    assert len(result.cells) == 101 * 201 + 100


def test_wavefront_larger_than_navfns_buffers_loses_no_cell():
    function = NavigationFunction(grids.of(np.zeros((3_000, 3_000), np.uint8)), (1_500, 1_500))
    function.grow()
    assert function.reached == 9_000_000
    assert function._buffers.shape[1] > 10_000


def test_path_first_leaves_inscribed_cells():
    result = plan(grids.costmap("ii....."), (0, 0), (0, 6))
    assert result.cells[:, 1].tolist() == list(range(7))
    assert result.poses[:3, 0].tolist() == [0.5, 1.5, 2.5]


def test_blocked_goal_is_refused_or_moved_within_the_tolerance():
    map_ = grids.costmap("....#")
    with pytest.raises(GoalOccupied):
        plan(map_, (0, 0), (0, 4))
    assert plan(map_, (0, 0), (0, 4), tolerance=1.5).cells[-1].tolist() == [0, 3]


def test_a_path_too_long_for_single_precision_is_refused(monkeypatch):
    function = NavigationFunction(grids.of(np.zeros((1, 50), np.uint8)), (0, 0))
    function._threshold[0] = 2.0**29
    with pytest.raises(InvalidPlanner, match="choose dijkstra"):
        function.grow()


def test_plan_can_be_cancelled_and_timed_out():
    map_ = grids.of(np.zeros((1_500, 1_500), np.uint8))
    calls = itertools.count()
    with pytest.raises(PlanCancelled):
        plan(map_, (0, 0), (1_499, 1_499), cancelled=lambda: next(calls) > 5)
    ticks = itertools.count()
    with pytest.raises(PlanTimeout):
        plan(map_, (0, 0), (1_499, 1_499), timeout=9.0, clock=lambda: float(next(ticks)))


@pytest.mark.parametrize("alias", ["navfn/NavfnROS", "nav2_navfn_planner/NavfnPlanner"])
def test_navfn_is_created_by_its_ros_names(alias):
    planner = create(alias, use_astar=True)
    assert isinstance(planner, NavFn)
    assert planner.use_astar
