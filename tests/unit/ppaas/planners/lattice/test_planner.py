"""The kinematic planner returns paths that a robot with a minimum turning radius can drive."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ppaas.clock import ManualClock
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.costmap import Costmap
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
from ppaas.planners import PlanRequest, create
from ppaas.planners.lattice import search
from ppaas.planners.lattice.planner import DOUBTFUL, Lattice
from robots.client.map_files import read_map_file
from tests.support.world import grids
from tests.support.world.drivable import assert_drivable

FOOTPRINT = [(0.35, 0.2), (0.35, -0.2), (-0.25, -0.2), (-0.25, 0.2)]
NORTH, SOUTH, EAST, WEST = math.pi / 2, -math.pi / 2, 0.0, math.pi
BOTH = {"motion_model_for_search": "REEDS_SHEPP"}


def walled(height, width, *rooms, resolution=0.05):
    """Return a map of obstacles with some free rooms: bottom, top, left, right."""
    costs = np.full((height, width), 254, np.uint8)
    for bottom, top, left, right in rooms:
        costs[bottom:top, left:right] = 0
    return grids.of(costs, resolution)


def planned(costmap, start, goal, *, radius=0.4, footprint=(), **parameters):
    """Plan, check the invariants of the path, and return it and its number of gear changes."""
    planner = create("lattice", minimum_turning_radius=radius, footprint=footprint, **parameters)
    result = planner.plan(costmap, PlanRequest(start, goal))
    backing = parameters.get("motion_model_for_search") == "REEDS_SHEPP"
    changes = assert_drivable(costmap, result, start, goal, radius, backing=backing, footprint=footprint)
    return result, changes


BAY = walled(80, 120, (50, 70, 5, 115), (20, 50, 80, 92))
"""A corridor 1 m wide with a dead end to its side, 0.6 m wide and 1.5 m deep."""
IN_CORRIDOR, IN_BAY = (1.0, 3.0), (4.3, 1.5)


def test_robot_drives_forward_into_a_dead_end():
    _, changes = planned(BAY, Pose2D(*IN_CORRIDOR, EAST), Pose2D(*IN_BAY, SOUTH), footprint=FOOTPRINT)
    assert changes == 0


def test_robot_reverses_into_and_out_of_a_dead_end_if_allowed():
    for start, goal in (
        (Pose2D(*IN_CORRIDOR, EAST), Pose2D(*IN_BAY, NORTH)),
        (Pose2D(*IN_BAY, SOUTH), Pose2D(*IN_CORRIDOR, WEST)),
    ):
        with pytest.raises(NoValidPath, match="REEDS_SHEPP"):
            planned(BAY, start, goal, footprint=FOOTPRINT)
        _, changes = planned(BAY, start, goal, footprint=FOOTPRINT, **BOTH)
        assert changes == 1


def test_robot_turns_around_in_a_narrow_corridor_by_reversing():
    corridor = walled(32, 120, (10, 22, 4, 116))
    start, goal = Pose2D(2.0, 0.8, EAST), Pose2D(2.0, 0.8, WEST)
    with pytest.raises(NoValidPath):
        planned(corridor, start, goal)
    _, changes = planned(corridor, start, goal, **BOTH)
    assert changes >= 2
    wider = walled(60, 120, (10, 50, 4, 116))
    assert planned(wider, Pose2D(2.0, 1.5, EAST), Pose2D(2.0, 1.5, WEST))[1] == 0


def test_robot_longer_than_the_corridor_width_cannot_turn_around():
    corridor = walled(32, 60, (10, 22, 4, 56))
    long_robot = [(0.5, 0.2), (0.5, -0.2), (-0.5, -0.2), (-0.5, 0.2)]
    with pytest.raises(NoValidPath):
        planned(corridor, Pose2D(1.5, 0.8, EAST), Pose2D(1.5, 0.8, WEST), footprint=long_robot, **BOTH)
    planned(corridor, Pose2D(1.0, 0.8, EAST), Pose2D(2.0, 0.8, EAST), footprint=long_robot, **BOTH)


def test_path_in_free_space_is_the_shortest_curve():
    open_ = grids.of(np.zeros((100, 100), np.uint8), 0.1)
    result, _ = planned(open_, Pose2D(2.0, 2.0, EAST), Pose2D(8.0, 2.0, EAST))
    assert result.length == pytest.approx(6.0)
    result, changes = planned(open_, Pose2D(5.0, 5.0, EAST), Pose2D(3.0, 5.0, EAST), reverse_penalty=1.0, **BOTH)
    assert result.length == pytest.approx(2.0)
    assert changes == 0
    result, _ = planned(open_, Pose2D(5.0, 5.0, EAST), Pose2D(5.0, 7.0, WEST), radius=1.0)
    assert result.length == pytest.approx(math.pi, abs=0.01)


def test_long_reversing_costs_more_than_turning_around():
    open_ = grids.of(np.zeros((100, 200), np.uint8), 0.1)
    start, goal = Pose2D(18.0, 5.0, EAST), Pose2D(2.0, 5.0, EAST)
    cheap, _ = planned(open_, start, goal, reverse_penalty=1.0, **BOTH)
    assert cheap.length == pytest.approx(16.0)
    costly, _ = planned(open_, start, goal, reverse_penalty=4.0, **BOTH)
    steps = np.diff(costly.poses[:, :2], axis=0)
    yaws = np.array([yaw_of(*row[3:]) for row in costly.poses[:-1].tolist()])
    forward = (steps[:, 0] * np.cos(yaws) + steps[:, 1] * np.sin(yaws)) > 0.0
    assert np.hypot(*steps[forward].T).sum() > 14.0


def test_a_higher_cost_penalty_keeps_the_path_out_of_high_costs():
    costs = np.zeros((60, 100), np.uint8)
    costs[25:35, 30:70] = 200
    map_ = grids.of(costs, 0.1)
    ends = Pose2D(1.0, 3.0, EAST), Pose2D(9.0, 3.0, EAST)
    assert planned(map_, *ends, cost_penalty=0.0)[0].length == pytest.approx(8.0)
    around = planned(map_, *ends, cost_penalty=4.0)[0]
    assert around.length > 8.05
    assert np.count_nonzero(costs[around.cells[:, 0], around.cells[:, 1]]) < 8


@given(st.integers(0, 10_000), st.booleans(), st.booleans())
def test_every_path_is_drivable(seed, backing, outlined):
    rng = np.random.default_rng(seed)
    costs = rng.choice([0, 60, 252], (50, 60)).astype(np.uint8)
    costs[rng.random(costs.shape) < 0.01] = 254
    map_ = grids.of(costs, 0.1, Pose2D(-3.0, 2.0, rng.uniform(-3.0, 3.0)))
    ends = []
    for _ in range(2):
        x, y = (map_.info.to_world(rng.integers(5, 45, 2)) + rng.uniform(-0.05, 0.05, 2)).tolist()
        ends.append(Pose2D(x, y, rng.uniform(-3.0, 3.0)))
    footprint = [(0.2, 0.1), (0.2, -0.1), (-0.1, 0.0)] if outlined else ()
    try:
        planned(map_, *ends, footprint=footprint, tolerance=0.0, max_iterations=20_000, **(BOTH if backing else {}))
    except (GoalOccupied, StartOccupied, NoValidPath, PlanTimeout):
        assume(False)


@pytest.fixture(scope="module")
def depot(data):
    return build_layers(read_map_file(data / "ros" / "depot.yaml")).costmap


@pytest.mark.parametrize("model", ["DUBIN", "REEDS_SHEPP"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_paths_across_a_depot_are_drivable_and_short(depot, model, seed):
    rng = np.random.default_rng(seed)
    free = np.argwhere(depot.data == 0)
    left, right = free[free[:, 1] < 150], free[free[:, 1] > 450]
    start, goal = (
        Pose2D(*depot.info.to_world(cells[rng.integers(len(cells))]).tolist(), rng.uniform(-3.0, 3.0))
        for cells in (left, right)
    )
    result, changes = planned(depot, start, goal, motion_model_for_search=model)
    assert changes <= 2
    least = create("dijkstra").plan(depot, PlanRequest(start, goal))
    assert result.length < 1.1 * least.length + 4.0 * 0.4
    smoothed = create("lattice", motion_model_for_search=model, smooth_path=False)
    assert result.length <= smoothed.plan(depot, PlanRequest(start, goal)).length + 1e-6


def test_start_equal_to_the_goal_gives_one_cell():
    map_ = grids.of(np.zeros((5, 5), np.uint8))
    result = Lattice().plan(map_, PlanRequest(Pose2D(2.3, 2.4, 1.0), Pose2D(2.3, 2.4, 1.0)))
    assert result.cells.tolist() == [[2, 2]]
    assert (result.cost, result.length, len(result.poses)) == (0.0, 0.0, 1)


def test_unknown_cells_are_entered_only_if_allowed():
    costs = np.zeros((30, 60), np.uint8)
    costs[:, 30] = 255
    map_, ends = grids.of(costs, 0.1), (Pose2D(1.0, 1.5), Pose2D(5.0, 1.5))
    assert planned(map_, *ends)[0].length == pytest.approx(4.0)
    with pytest.raises(NoValidPath):
        planned(map_, *ends, allow_unknown=False)


def test_path_leaves_inscribed_cells_and_stays_out():
    costs = np.zeros((40, 60), np.uint8)
    costs[:, :4] = 254
    costs[:, 4:8] = 253
    map_ = grids.of(costs, 0.05)
    result = Lattice().plan(map_, PlanRequest(Pose2D(0.25, 1.0, EAST), Pose2D(2.5, 1.0, EAST)))
    inscribed = costs[result.cells[:, 0], result.cells[:, 1]] == 253
    assert inscribed[0]
    assert not inscribed[np.argmin(inscribed) :].any()
    assert result.length == pytest.approx(2.25)


def test_a_blocked_goal_is_replaced_within_the_tolerance():
    costs = np.zeros((40, 60), np.uint8)
    costs[:, 50:] = 254
    map_ = grids.of(costs, 0.05)
    ends = Pose2D(0.5, 1.0, EAST), Pose2D(2.62, 1.02, EAST)
    for planner, tolerance in ((create("lattice", tolerance=0.25), 0.0), (create("lattice"), 0.25)):
        assert planner.plan(map_, PlanRequest(*ends, tolerance)).cells[-1].tolist() == [20, 49]
    for planner, tolerance in ((create("lattice", tolerance=0.1), 0.0), (create("lattice"), 0.0)):
        with pytest.raises(GoalOccupied, match=f"tolerance of {max(tolerance, planner.parameters.tolerance)} m"):
            planner.plan(map_, PlanRequest(*ends, tolerance))


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
def test_each_failure_has_its_error_type_and_position(start, goal, error, text):
    with pytest.raises(error, match=text):
        Lattice().plan(grids.costmap(".#."), PlanRequest(start, goal))


def test_a_footprint_that_touches_an_obstacle_at_either_end_is_refused():
    map_ = walled(40, 60, (10, 30, 5, 55))
    free, close = Pose2D(1.5, 1.0, EAST), Pose2D(1.5, 0.65, EAST)
    planner = create("lattice", footprint=FOOTPRINT, **BOTH)
    with pytest.raises(StartOccupied, match="footprint"):
        planner.plan(map_, PlanRequest(close, free))
    with pytest.raises(GoalOccupied, match="footprint"):
        planner.plan(map_, PlanRequest(free, close))


HARD = walled(400, 400, (10, 390, 10, 200), (10, 390, 220, 390), (200, 206, 200, 220), resolution=0.05)
"""Two halls; the robot would have to turn on the spot to leave the door with the requested heading."""
HARD_ENDS = Pose2D(2.0, 2.0, EAST), Pose2D(10.5, 10.15, NORTH)


@pytest.mark.parametrize("checks", [0, 1, 5, 40])
def test_cancelled_plan_ends_at_the_next_check(checks):
    count = 0

    def cancelled():
        nonlocal count
        count += 1
        return count > checks

    with pytest.raises(PlanCancelled):
        Lattice().plan(HARD, PlanRequest(*HARD_ENDS, cancelled=cancelled))
    assert count == checks + 1


@pytest.mark.parametrize(("timeout", "allowed"), [(2.0, 2.0), (math.inf, 5.0)])
def test_deadline_of_the_request_or_the_planner_applies(timeout, allowed):
    clock = ManualClock(100.0)

    def tick():
        clock.advance(0.25)
        return clock()

    with pytest.raises(PlanTimeout, match=f"{allowed} s"):
        Lattice().plan(HARD, PlanRequest(*HARD_ENDS, clock=tick, timeout=timeout))
    assert clock() == 100.25 + allowed


def test_no_more_nodes_are_expanded_than_allowed():
    with pytest.raises(PlanTimeout, match="max_iterations"):
        Lattice(max_iterations=30).plan(HARD, PlanRequest(HARD_ENDS[0], Pose2D(15.0, 15.0, NORTH)))


YARD = walled(600, 600, (50, 599, 1, 599), (20, 50, 80, 92))
"""A large open area with a dead end to its side, 0.6 m wide and 1.5 m deep."""


def test_an_unreachable_heading_is_refused_without_searching_the_whole_map():
    checks = 0

    def cancelled():
        nonlocal checks
        checks += 1
        return False

    request = PlanRequest(Pose2D(20.0, 20.0, EAST), Pose2D(*IN_BAY, NORTH), cancelled=cancelled)
    with pytest.raises(NoValidPath, match="another goal or heading"):
        Lattice(tolerance=0.0, max_planning_time=1e9).plan(YARD, request)
    assert checks < 2 * DOUBTFUL / search.SLICE_NODES + 100
    planned(YARD, Pose2D(20.0, 20.0, EAST), Pose2D(*IN_BAY, SOUTH))
    planned(YARD, Pose2D(20.0, 20.0, EAST), Pose2D(*IN_BAY, NORTH), **BOTH)


def test_unreachable_heading_searches_the_smaller_part_of_the_map():
    dead_end = walled(300, 300, (130, 150, 1, 260), (100, 210, 250, 299), (210, 299, 1, 299))
    checks = 0

    def cancelled():
        nonlocal checks
        checks += 1
        return False

    request = PlanRequest(Pose2D(7.0, 12.0, EAST), Pose2D(9.0, 7.0, EAST), cancelled=cancelled)
    forward = Lattice(tolerance=0.0, max_planning_time=1e9, minimum_turning_radius=2.0)
    with pytest.raises(NoValidPath, match="another goal or heading"):
        forward.plan(dead_end, request)
    assert checks < 5_000  # searching from the start only would take three times as many
    planned(dead_end, Pose2D(7.0, 12.0, EAST), Pose2D(9.0, 7.0, WEST), radius=2.0)


def test_uninitialized_memory_does_not_affect_the_path(monkeypatch):
    start, goal = Pose2D(*IN_BAY, SOUTH), Pose2D(*IN_CORRIDOR, WEST)
    expected = planned(BAY, start, goal, footprint=FOOTPRINT, **BOTH)[0]
    clean = np.empty
    for rubbish in (-7, 3):

        def littered(shape, dtype=np.float64, rubbish=rubbish, **how):
            array = clean(shape, dtype, **how)
            array.fill(np.nan if array.dtype.kind == "f" and rubbish < 0 else abs(rubbish))
            return array

        monkeypatch.setattr(np, "empty", littered)
        result = planned(BAY, start, goal, footprint=FOOTPRINT, **BOTH)[0]
        assert np.array_equal(result.poses, expected.poses)
        assert result.expanded == expected.expanded


def test_costmap_is_not_modified():
    data = np.random.default_rng(1).integers(0, 253, (50, 50)).astype(np.uint8)
    before = data.copy()
    data.flags.writeable = False
    Lattice().plan(grids.of(data, 0.1), PlanRequest(Pose2D(1.0, 1.0), Pose2D(4.0, 4.0), threads=2))
    assert np.array_equal(data, before)


def test_maps_of_one_cell_or_one_row_are_planned():
    assert Lattice().plan(grids.costmap("."), PlanRequest(Pose2D(0.5, 0.5), Pose2D(0.5, 0.5))).length == 0.0
    row = Costmap(np.zeros((1, 300), np.uint8), grids.of(np.zeros((1, 300), np.uint8), 0.05).info)
    result, _ = planned(row, Pose2D(0.2, 0.025, EAST), Pose2D(14.0, 0.025, EAST))
    assert len(result.cells) == 277
