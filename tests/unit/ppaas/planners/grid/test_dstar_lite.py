"""After any map changes and robot moves, paths are as cheap as those of a new search, with few expansions."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from ppaas.clock import ManualClock
from ppaas.costmap.costmap import Costmap
from ppaas.errors import GoalOccupied, NoValidPath, PlanCancelled, PlanTimeout
from ppaas.geometry import Pose2D
from ppaas.maps.formats.movingai import parse_map, parse_scenario
from ppaas.maps.grid import GridInfo
from ppaas.planners import PlanRequest, create
from ppaas.planners.field.cost_field import CostField
from ppaas.planners.grid.dstar_lite import DStarLite, DStarLiteField
from ppaas.planners.weights import RELATIVE_ERROR, fixed_weights, passable
from tests.reference.planners import dijkstra as twin
from tests.support.world import grids

KINDS = st.sampled_from([0, 0, 0, 7, 128, 252, 253, 254, 255])


def plan(planner, costs, start, goal, **request):
    map_ = grids.of(costs)
    return planner.plan(map_, PlanRequest(grids.centre(map_, *start), grids.centre(map_, *goal), **request))


def in_fixed_point(costs, cells):
    """Return the weight of a path in fixed point."""
    diagonal = (np.abs(np.diff(cells, axis=0)).sum(axis=1) == 2).astype(int)
    return int(fixed_weights()[diagonal, costs[tuple(cells[:-1].T)]].sum())


@st.composite
def histories(draw):
    """Draw a goal, and a history of maps and robot cells."""
    shape = draw(st.tuples(st.integers(1, 9), st.integers(1, 9)))
    allow_unknown = draw(st.booleans())
    costs = draw(hnp.arrays(np.uint8, shape, elements=KINDS))
    goal = draw(st.tuples(st.integers(0, shape[0] - 1), st.integers(0, shape[1] - 1)))
    steps = []
    for _ in range(draw(st.integers(2, 8))):
        for _ in range(draw(st.integers(0, 6))):
            cell = draw(st.tuples(st.integers(0, shape[0] - 1), st.integers(0, shape[1] - 1)))
            costs[cell] = draw(KINDS)
        costs[goal] = min(costs[goal], 252)
        free = np.argwhere(passable(allow_unknown)[costs])
        steps.append((costs.copy(), tuple(draw(st.sampled_from(free.tolist())))))
    return goal, allow_unknown, steps


@given(histories())
def test_path_weight_agrees_with_the_twin_after_changes_and_moves(history):
    goal, allow_unknown, steps = history
    planner = DStarLite(allow_unknown=allow_unknown)
    for costs, start in steps:
        least = twin.fixed_field(costs, [goal], allow_unknown)[start[0]][start[1]]
        if least < 0:
            with pytest.raises(NoValidPath):
                plan(planner, costs, start, goal)
            continue
        result = plan(planner, costs, start, goal)
        assert (tuple(result.cells[0]), tuple(result.cells[-1])) == (start, goal)
        assert in_fixed_point(costs, result.cells) == least
        steps_apart = np.abs(np.diff(result.cells, axis=0)).max(axis=1, initial=0)
        assert (steps_apart[: len(result.cells) - 1] == 1).all()


@pytest.mark.parametrize("graded", [False, True])
def test_path_weights_along_a_drive_agree_with_a_new_field(graded):
    rng = np.random.default_rng(8)
    costs = rng.integers(0, 200 if graded else 1, (150, 170)).astype(np.uint8)
    costs[rng.random(costs.shape) < 0.2] = 254
    costs[:4, :4] = costs[-4:, -4:] = 0
    goal, start = (147, 167), (2, 2)
    field = DStarLiteField(grids.of(costs), goal)
    fresh = 0
    for step in range(40):
        row, column = (int(rng.integers(0, size - 9)) for size in costs.shape)
        block = costs[row : row + 9, column : column + 9]
        block[:] = rng.choice([0, 254, 90], block.shape, p=[0.6, 0.3, 0.1])
        costs[:4, :4] = costs[-4:, -4:] = costs[start] = 0
        map_ = grids.of(costs)
        field.amend(map_, field.differing(map_))
        fresh_field = CostField(map_, np.array([goal]))
        assert field.reach(start) == fresh_field.grow(start)
        if field.value < 10**15:
            cells = field.path()
            assert field.value == in_fixed_point(costs, cells) == round(fresh_field.values()[start] * 85)
            start = tuple(cells[min(3, len(cells) - 1)].tolist())
        fresh += fresh_field.settled
        assert not len(field.differing(map_)), step
    assert field.settled < fresh / 2


def test_replanned_paths_on_real_maps_are_as_cheap_as_new_ones(data):
    file = data / "movingai" / "dao" / "arena2.map"
    costs = np.where(parse_map(file.read_bytes()).data == 0, 0, 254).astype(np.uint8)
    queries = parse_scenario(file.with_suffix(".map.scen").read_bytes())
    start, goal = (tuple(cells[-1].tolist()) for cells in (queries.starts, queries.goals))
    planner, other = DStarLite(), create("dijkstra")
    old_path = plan(planner, costs, start, goal).cells
    for at in (10, 40, 80):
        row, column = old_path[at] - 3
        costs[row : row + 7, column : column + 7] = 254
        result = plan(planner, costs, start, goal)
        assert result.cost == pytest.approx(plan(other, costs, start, goal).cost, rel=2 * RELATIVE_ERROR)
        assert result.expanded < plan(DStarLite(), costs, start, goal).expanded


# -- expansions -------------------------------------------------------------------------------------------------------

CLUTTERED = np.where(np.random.default_rng(3).random((300, 300)) < 0.2, 254, 0).astype(np.uint8)
CLUTTERED[:9, :9] = CLUTTERED[-9:, -9:] = 0


def test_without_changes_no_cell_is_expanded_again():
    planner = DStarLite()
    first = plan(planner, CLUTTERED, (4, 4), (295, 295))
    again = plan(planner, CLUTTERED.copy(), (4, 4), (295, 295))
    assert first.expanded > 1_000
    assert again.expanded == 0
    assert np.array_equal(again.cells, first.cells)


def test_following_the_path_expands_few_cells():
    planner = DStarLite()
    cells = plan(planner, CLUTTERED, (4, 4), (295, 295)).cells
    moved = [plan(planner, CLUTTERED, tuple(cells[at].tolist()), (295, 295)) for at in (1, 5, 50, 200)]
    assert sum(result.expanded for result in moved) < 10
    assert all(len(result.cells) < len(cells) for result in moved)


def test_new_obstacle_ahead_expands_few_cells():
    planner, costs = DStarLite(), CLUTTERED.copy()
    first = plan(planner, costs, (4, 4), (295, 295))
    row, column = first.cells[20]
    costs[row - 2 : row + 3, column - 2 : column + 3] = 254
    result = plan(planner, costs, (4, 4), (295, 295))
    assert 0 < result.expanded < first.expanded / 10
    assert not costs[tuple(result.cells.T)].any()


def test_changes_behind_the_robot_cause_few_expansions():
    planner, costs = DStarLite(), CLUTTERED.copy()
    cells = plan(planner, costs, (4, 4), (295, 295)).cells
    start = tuple(cells[150].tolist())
    costs[10:30, 10:30] = 254
    assert plan(planner, costs, start, (295, 295)).expanded < 50


@pytest.mark.parametrize("share", [0.01, 0.5])
def test_path_is_right_on_a_completely_changed_map(share):
    rng = np.random.default_rng(6)
    planner = DStarLite()
    for _ in range(3):
        costs = CLUTTERED.copy()
        changed = rng.random(costs.shape) < share
        costs[changed] = rng.integers(0, 250, changed.sum())
        costs[:9, :9] = costs[-9:, -9:] = 0
        expected = plan(create("dijkstra"), costs, (4, 4), (295, 295)).cost
        assert plan(planner, costs, (4, 4), (295, 295)).cost == pytest.approx(expected, rel=2 * RELATIVE_ERROR)


def test_another_goal_or_map_size_starts_a_new_field():
    planner = DStarLite()
    for shape, goal in (((300, 300), (295, 295)), ((300, 300), (295, 200)), ((200, 250), (199, 200)), ((9, 9), (8, 8))):
        costs = CLUTTERED[: shape[0], : shape[1]].copy()
        costs[goal[0] - 4 : goal[0] + 1, goal[1] - 4 : goal[1] + 1] = 0
        expected = plan(create("dijkstra"), costs, (4, 4), goal)
        result = plan(planner, costs, (4, 4), goal)
        assert result.cost == pytest.approx(expected.cost, rel=2 * RELATIVE_ERROR)
        assert result.expanded >= len(result.cells) - 1


# -- ends and cancellation --------------------------------------------------------------------------------------------


def test_closed_path_is_found_again_when_reopened():
    planner, costs = DStarLite(), np.zeros((9, 9), np.uint8)
    before = plan(planner, costs, (4, 0), (4, 8))
    costs[:, 4] = 254
    with pytest.raises(NoValidPath):
        plan(planner, costs, (4, 0), (4, 8))
    costs[:, 4] = 0
    assert plan(planner, costs, (4, 0), (4, 8)).cost == before.cost


def test_blocked_goal_is_reached_again_when_free():
    planner, costs = DStarLite(), np.zeros((9, 9), np.uint8)
    plan(planner, costs, (4, 0), (4, 8))
    costs[4, 8] = 254
    with pytest.raises(GoalOccupied):
        plan(planner, costs, (4, 0), (4, 8))
    assert plan(planner, costs, (4, 0), (4, 8), tolerance=1.5).cells[-1].tolist() in ([3, 8], [4, 7], [5, 8])
    costs[4, 8] = 0
    assert plan(planner, costs, (4, 0), (4, 8)).cost == 400.0


def test_start_equal_to_the_goal_gives_one_cell():
    result = plan(DStarLite(), np.zeros((1, 1), np.uint8), (0, 0), (0, 0))
    assert result.cells.tolist() == [[0, 0]]
    assert result.cost == 0.0


def test_row_of_32768_cells_at_the_highest_cost_is_traversed():
    planner, costs = DStarLite(), np.full((1, 32_768), 252, np.uint8)
    assert plan(planner, costs, (0, 32_767), (0, 0)).cost == pytest.approx(32_767 * 251.6)
    costs[0, 9] = 0
    result = plan(planner, costs, (0, 32_767), (0, 0))
    assert result.cost == pytest.approx(32_767 * 251.6 - 201.6)
    assert len(result.poses) == 32_768


def test_a_new_field_is_grown_after_the_robot_has_moved_too_far(monkeypatch):
    monkeypatch.setattr("ppaas.planners.grid.dstar_lite.MAX_MOVED", 2.5 * 4250)
    planner = DStarLite()
    expanded = [plan(planner, CLUTTERED[:9, :9], (0, column), (0, 8)).expanded for column in range(5)]
    assert expanded == [9, 0, 0, 0, 5]


def test_a_cancelled_plan_is_resumed_by_the_next():
    planner = DStarLite()
    for most in range(3, 40, 4):
        calls = itertools.count()
        costs = CLUTTERED.copy()
        costs[100:130, 100 + most : 130 + most] = 254 if most % 8 else 0
        try:
            plan(planner, costs, (4, 4), (295, 295), cancelled=lambda calls=calls, most=most: next(calls) >= most)
        except PlanCancelled:
            assert next(calls) == most + 1
    expected = plan(create("dijkstra"), CLUTTERED, (4, 4), (295, 295)).cost
    assert plan(planner, CLUTTERED, (4, 4), (295, 295)).cost == pytest.approx(expected, rel=2 * RELATIVE_ERROR)


def test_deadline_ends_the_plan():
    clock = ManualClock()

    def tick():
        clock.advance(0.25)
        return clock()

    with pytest.raises(PlanTimeout):
        plan(DStarLite(), CLUTTERED, (4, 4), (295, 295), clock=tick, timeout=1.0)


def test_two_planners_do_not_share_fields_and_only_read_the_map():
    costs = CLUTTERED.copy()
    costs.flags.writeable = False
    one, two = DStarLite(), DStarLite()
    plan(one, costs, (4, 4), (295, 295))
    assert plan(two, costs, (4, 4), (295, 295)).expanded > 1_000
    assert np.array_equal(costs, CLUTTERED)
    assert plan(one.twin(), costs, (4, 4), (295, 295)).expanded > 1_000


def test_shifted_map_is_treated_as_changed():
    planner = DStarLite()
    for shift in (0, 1, 2):
        part = np.ascontiguousarray(CLUTTERED[:60, shift : 60 + shift])
        map_ = Costmap(part, GridInfo(0.1, 60, 60, Pose2D(0.1 * shift, 0.0)))
        request = PlanRequest(Pose2D(0.55, 0.55), Pose2D(0.85, 0.15))
        assert planner.plan(map_, request).cost == create("dijkstra").plan(map_, request).cost
