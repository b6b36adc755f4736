"""Times of plans and quarter turns agree with their slow twins; no two robots ever share a cell or crowd an area."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ppaas.errors import NoValidPath
from ppaas.fleet.first_plan import first_plan
from ppaas.fleet.kernels.turns import DIRECTIONS, count_quarters, direction, least_quarters, quarters
from ppaas.fleet.plan import FleetPlan, timing_of, turns_of
from ppaas.fleet.problem import FleetProblem
from ppaas.fleet.roadmap import Roadmap
from tests.reference.fleet import searches, timing
from tests.reference.fleet import searches as turns
from tests.support.fleet.halls import Hall, halls, ruled_halls
from tests.support.fleet.walks import walks

STEPS = 9
QUARTERS = st.integers(1, 16).map(lambda number: number / 4.0)
"""Durations [s] that floats hold exactly."""


@given(halls(most_robots=4), st.data())
def test_times_agree_with_their_twin_and_no_two_robots_share_a_cell(hall: Hall, data: st.DataObject) -> None:
    steps = data.draw(walks(hall.roadmap, hall.starts, STEPS)).T
    moves = data.draw(st.lists(QUARTERS, min_size=len(hall.starts), max_size=len(hall.starts)))
    turn = data.draw(st.just(0.0) | QUARTERS)
    plan = FleetPlan(np.ascontiguousarray(steps), 0)
    found, turned = timing_of(hall.roadmap, plan, np.array(moves), turn)
    assert found == pytest.approx(np.array(timing.times(hall.roadmap, steps.tolist(), moves, turn)), abs=1e-9)
    times = found.round(9).tolist()
    assert timing.shared(steps.tolist(), times, moves) == []
    assert timing.hasty(hall.roadmap, steps.tolist(), times, moves, turn) == []
    quarters = [searches.count(hall.roadmap, path) for path in steps.T.tolist()]
    assert turns_of(hall.roadmap, plan).tolist() == quarters
    assert turned == pytest.approx(quarters)


@given(ruled_halls(), st.data())
def test_areas_have_room_for_those_who_enter_them(hall: Hall, data: st.DataObject) -> None:
    try:
        plan = first_plan(FleetProblem.of(hall.roadmap, *hall.places()))
    except NoValidPath:
        assume(False)
    steps = plan.steps.tolist()
    moves = data.draw(st.lists(QUARTERS, min_size=len(hall.starts), max_size=len(hall.starts)))
    turn = data.draw(st.just(0.0) | QUARTERS)
    times = timing_of(hall.roadmap, plan, np.array(moves), turn).times.round(9).tolist()
    assert timing.shared(steps, times, moves) == []
    assert timing.hasty(hall.roadmap, steps, times, moves, turn) == []
    assert timing.crowded(hall.roadmap, steps, times, moves) == []


@pytest.mark.parametrize(
    ("paths", "moves", "turn", "times"),
    [
        ([[0, 1, 2]], [1.5], 1.0, [[0.0, 1.5, 3.0]]),
        ([[0, 1, 4, 3]], [1.0], 2.0, [[0.0, 1.0, 4.0, 7.0]]),
        ([[0, 1, 1, 0]], [1.0], 2.0, [[0.0, 1.0, 1.0, 6.0]]),
        ([[1, 2, 5], [0, 1, 2]], [2.0, 1.0], 0.0, [[0.0, 2.0, 4.0], [0.0, 3.0, 5.0]]),
    ],
)
def test_robots_turn_before_they_move_and_follow_each_other(
    paths: list[list[int]], moves: list[float], turn: float, times: list[list[float]]
) -> None:
    roadmap = Roadmap.of_grid(np.ones((2, 3), np.bool_))
    plan = FleetPlan(np.ascontiguousarray(np.array(paths, np.int32).T), 0)
    assert pytest.approx(np.array(times)) == timing_of(roadmap, plan, np.array(moves), turn).times.T


def test_a_plan_without_robots_has_no_times() -> None:
    roadmap = Roadmap.of_grid(np.ones((2, 3), np.bool_))
    assert timing_of(roadmap, FleetPlan(np.empty((1, 0), np.int32), 0), np.empty(0)).times.shape == (1, 0)


def test_along_lanes_moves_take_as_long_as_they_are_and_turns_as_far_as_robots_turn() -> None:
    places = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [3.0, 2.0]])
    moves = np.array([[0, 1], [1, 2], [2, 3]], np.int32)
    plan = FleetPlan(np.array([[0], [1], [2], [3]], np.int32), 3)
    times, turned = timing_of(Roadmap.of_pairs(4, moves), plan, np.array([2.0]), 1.0, places)
    assert times[:, 0] == pytest.approx([0.0, 4.0, 7.0, 7.5 + 2.0 * 2.0**0.5])
    assert turned == pytest.approx([1.5])


ROADMAP = Roadmap.of_grid(np.ones((4, 4), np.bool_))
CELLS = st.integers(0, len(ROADMAP) - 1)


@pytest.mark.parametrize("before", range(DIRECTIONS))
@pytest.mark.parametrize("after", range(DIRECTIONS))
def test_quarter_turns_between_directions(before: int, after: int) -> None:
    assert quarters(before, after) == turns.quarters(turns.DIRECTIONS[before], turns.DIRECTIONS[after])


@given(CELLS, st.data())
def test_no_path_has_fewer_quarter_turns_than_the_least(start: int, data: st.DataObject) -> None:
    [path] = data.draw(walks(ROADMAP, [start], 9))
    heading = data.draw(st.integers(0, DIRECTIONS - 1))
    counted = turns.count(ROADMAP, path.tolist())
    assert count_quarters(ROADMAP.cells, path) == counted
    moved = [cell for cell in path if cell != start][:1]
    first = quarters(heading, direction(ROADMAP.cells, start, moved[0])) if moved else 0
    assert least_quarters(ROADMAP.cells, start, heading, path[-1]) <= first + counted


@pytest.mark.parametrize(
    ("heading", "goal", "least"),
    [(0, 5, 0), (0, 13, 0), (1, 9, 1), (2, 9, 2), (0, 10, 1), (1, 10, 1), (2, 10, 2), (3, 10, 2), (3, 4, 0), (1, 4, 2)],
)
def test_least_quarter_turns_from_a_cell(heading: int, goal: int, least: int) -> None:
    assert least_quarters(ROADMAP.cells, 5, heading, goal) == least
