"""The contract of every installed 2D planner."""

import math
from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from ppaas.costmap.costmap import LETHAL_OBSTACLE, NO_INFORMATION, Costmap
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
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.planners import PlanRequest, create, planner_names
from ppaas.planners.base import Planner, PlanResult
from ppaas.planners.traits import Optimal
from ppaas.planners.weights import passable
from ppaas.plugins import parameters_in_use

HIGHEST_COST = 252
RESOLUTION = 0.05
WIDEST = 32768

SOUTH = math.pi / 2.0
"""Along a column of cells, so that robots which cannot turn on the spot can drive it."""


@pytest.fixture(params=planner_names())
def planner(request: pytest.FixtureRequest) -> Planner:
    return create(request.param)


def costmap(costs: NDArray[np.integer]) -> Costmap:
    data = np.ascontiguousarray(costs, np.uint8)
    data.setflags(write=False)
    return Costmap(data, GridInfo(RESOLUTION, data.shape[1], data.shape[0]))


def free(height: int, width: int, cost: int = 0) -> Costmap:
    return costmap(np.full((height, width), cost))


def at(row: float, column: float, theta: float = 0.0) -> Pose2D:
    return Pose2D((column + 0.5) * RESOLUTION, (row + 0.5) * RESOLUTION, theta)


def check_path(result: PlanResult, map_: Costmap, request: PlanRequest) -> None:
    """Check that a robot can follow a path from its start to its goal."""
    cells = result.cells
    assert passable(True)[map_.data[tuple(cells.T)]].all()
    assert (np.abs(np.diff(cells, axis=0)).max(axis=1, initial=1) == 1).all()
    np.testing.assert_allclose(result.poses[0, :2], request.start[:2])
    np.testing.assert_allclose(result.poses[-1, :2], request.goal[:2])
    assert np.isfinite(result.poses).all()


def test_a_path_to_the_start_has_length_zero(planner: Planner) -> None:
    request = PlanRequest(at(20, 20), at(20, 20))
    result = planner.plan(free(40, 40), request)
    assert {tuple(cell) for cell in result.cells.tolist()} == {(20, 20)}
    assert (result.length, result.cost) == (0.0, 0.0)


def test_a_map_of_one_cell_can_be_planned_on(planner: Planner) -> None:
    result = planner.plan(free(1, 1), PlanRequest(at(0, 0), at(0, 0)))
    assert result.cells[[0, -1]].tolist() == [[0, 0], [0, 0]] and result.length == 0.0


@pytest.mark.parametrize(("shape", "theta"), [((1, 60), 0.0), ((60, 1), SOUTH)])
def test_a_map_one_cell_wide_can_be_planned_on(planner: Planner, shape: tuple[int, int], theta: float) -> None:
    map_ = free(*shape)
    request = PlanRequest(at(0, 0, theta), at(shape[0] - 1, shape[1] - 1, theta))
    result = planner.plan(map_, request)
    check_path(result, map_, request)
    assert len(result.cells) == 60
    assert result.cost == pytest.approx(59 * 50.0)


def test_the_widest_map_can_be_planned_on(planner: Planner) -> None:
    map_, request = free(32, WIDEST), PlanRequest(at(16, 0), at(16, WIDEST - 1))
    result = planner.plan(map_, request)
    check_path(result, map_, request)
    assert result.length == pytest.approx((WIDEST - 1) * RESOLUTION, rel=0.01)


@pytest.mark.parametrize("cost", [1, HIGHEST_COST])
def test_costs_at_the_limits_are_counted(planner: Planner, cost: int) -> None:
    map_, request = free(60, 60, cost), PlanRequest(at(30, 5), at(30, 54))
    result = planner.plan(map_, request)
    check_path(result, map_, request)
    assert result.cost == pytest.approx(49 * (50.0 + 0.8 * cost), rel=0.001)


def test_weighted_planners_avoid_expensive_cells(planner: Planner) -> None:
    costs = np.zeros((80, 80), np.uint8)
    costs[36:78, 30:50] = HIGHEST_COST
    map_, request = costmap(costs), PlanRequest(at(40, 5), at(40, 74))
    result = planner.plan(map_, request)
    check_path(result, map_, request)
    went_through = (map_.data[tuple(result.cells.T)] == HIGHEST_COST).any()
    assert went_through != planner.traits.weighted


def test_no_planner_plans_through_walls(planner: Planner) -> None:
    costs = np.zeros((60, 60), np.uint8)
    costs[20:41, 20:41] = LETHAL_OBSTACLE
    costs[23:38, 23:38] = 0
    walled = costmap(costs)
    with pytest.raises(NoValidPath, match="no "):
        planner.plan(walled, PlanRequest(at(5, 5), at(30, 30)))
    with pytest.raises(NoValidPath):
        planner.plan(walled, PlanRequest(at(30, 30), at(5, 5)))


def test_a_fully_occupied_map_is_refused(planner: Planner) -> None:
    with pytest.raises(StartOccupied):
        planner.plan(free(30, 30, LETHAL_OBSTACLE), PlanRequest(at(5, 5), at(20, 20)))


def test_a_goal_in_a_wall_needs_a_tolerance(planner: Planner) -> None:
    costs = np.zeros((60, 60), np.uint8)
    costs[30:34] = LETHAL_OBSTACLE
    map_, start = costmap(costs), at(10, 20, SOUTH)
    strict = create(planner.name, tolerance=0.0) if "tolerance" in parameters_in_use(planner) else planner
    with pytest.raises(GoalOccupied, match="tolerance"):
        strict.plan(map_, PlanRequest(start, at(31, 20, SOUTH)))
    result = planner.plan(map_, PlanRequest(start, at(31, 20, SOUTH), tolerance=0.15))
    check_path(result, map_, PlanRequest(start, at(29, 20, SOUTH)))


@pytest.mark.parametrize("allowed", [True, False])
def test_unknown_cells_are_entered_only_if_allowed(planner: Planner, allowed: bool) -> None:
    costs = np.zeros((60, 60), np.uint8)
    costs[:, 25:35] = NO_INFORMATION
    configured = create(planner.name, allow_unknown=allowed)
    request = PlanRequest(at(30, 10), at(30, 50))
    if allowed:
        check_path(configured.plan(costmap(costs), request), costmap(costs), request)
        return
    with pytest.raises(NoValidPath):
        configured.plan(costmap(costs), request)


@pytest.mark.parametrize(
    ("request_", "error"),
    [
        (PlanRequest(Pose2D(math.nan, 0.1, 0.0), at(5, 5)), InvalidInput),
        (PlanRequest(at(5, 5), Pose2D(0.1, math.inf, 0.0)), InvalidInput),
        (PlanRequest(at(5, 5), Pose2D(0.1, 0.1, math.nan)), InvalidInput),
        (PlanRequest(at(5, 5), at(9, 9), tolerance=-0.1), InvalidInput),
        (PlanRequest(at(5, 5), at(9, 9), timeout=math.nan), InvalidInput),
        (PlanRequest(at(5, 5), at(9, 9), threads=0), InvalidInput),
        (PlanRequest(at(-1, 5), at(9, 9)), StartOutsideMap),
        (PlanRequest(at(5, 5), at(9, 30)), GoalOutsideMap),
        (PlanRequest(at(5, 5), at(9, 9), timeout=0.0), PlanTimeout),
    ],
)
def test_invalid_requests_are_refused_with_a_reason(
    planner: Planner, request_: PlanRequest, error: type[Exception]
) -> None:
    with pytest.raises(error, match=r"\w+"):
        planner.plan(free(30, 30), request_)


def cancelled_after(number: int) -> Iterator[bool]:
    """Yield False ``number`` times, then True; a further call is an error."""
    yield from (False for _ in range(number))
    yield True
    raise AssertionError("it went on after it was cancelled")


def test_planning_stops_at_any_cancellation(planner: Planner) -> None:
    costs = np.zeros((700, 700), np.uint8)
    costs[40:-40:80, :-40] = costs[80:-40:80, 40:] = LETHAL_OBSTACLE
    map_, times = costmap(costs), 0

    def count() -> bool:
        nonlocal times
        times += 1
        return False

    request = PlanRequest(at(10, 10), at(690, 690))
    create(planner.name).plan(map_, PlanRequest(request.start, request.goal, cancelled=count))
    assert times > 3
    for number in {0, times // 2, times - 1}:
        answers = cancelled_after(number)
        with pytest.raises(PlanCancelled):
            create(planner.name).plan(
                map_, PlanRequest(request.start, request.goal, cancelled=lambda answers=answers: next(answers))
            )


def test_optimal_planners_find_paths_of_equal_cost() -> None:
    costs = np.random.default_rng(7).integers(0, 255, (50, 60)).astype(np.uint8)
    costs[[2, 47], [2, 57]] = 0
    map_, request = costmap(costs), PlanRequest(at(2, 2), at(47, 57))
    optimal = [name for name in planner_names() if create(name).traits.optimal is Optimal.ALWAYS]
    found = [create(name).plan(map_, request).cost for name in optimal]
    assert len(found) > 1
    np.testing.assert_allclose(found, found[0], rtol=1e-6)
