"""Roadmaps of grids, and plans between places in metres, which are valid and keep robots apart."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from benchmarks.fleet.checking import faults_of
from ppaas.errors import InvalidInput, PlanningError
from ppaas.fleet import metric_roadmap
from ppaas.fleet.first_plan import first_plan
from ppaas.fleet.improvement import Improvement
from ppaas.fleet.lattice_roadmap import lattice_roadmap
from ppaas.fleet.metric_roadmap import WITHIN, MetricFloor
from ppaas.fleet.roadmap import Roadmap
from ppaas.fleet.robot_sizes import RobotSizes
from tests.support.fleet.floors import Floor, floor_of, floors
from tests.support.fleet.halls import Hall, halls, ruled_halls


@given(halls(most_cells=30))
def test_neighbours_are_the_free_cells_beside_a_cell_and_each_is_a_neighbour_of_its_neighbours(hall: Hall) -> None:
    roadmap = hall.roadmap
    for cell, own in enumerate(roadmap.neighbours):
        found = {int(near) for near in own if near >= 0}
        beside = np.abs(roadmap.cells - roadmap.cells[cell]).sum(axis=1) == 1
        assert found == set(np.nonzero(beside)[0].tolist())
        assert (own[len(found) :] == -1).all()
        assert all(cell in roadmap.neighbours[near] for near in found)


@given(ruled_halls(most_cells=30))
def test_incoming_moves_are_the_moves_of_others(hall: Hall) -> None:
    outward = {(cell, int(near)) for cell, own in enumerate(hall.roadmap.neighbours) for near in own if near >= 0}
    inward = {(int(near), cell) for cell, own in enumerate(hall.roadmap.incoming) for near in own if near >= 0}
    assert outward == inward
    for own in (*hall.roadmap.neighbours, *hall.roadmap.incoming):
        assert (np.diff((own >= 0).astype(int)) <= 0).all(), "−1 is behind the last one"


@given(st.data(), st.integers(1, 4), st.integers(1, 4))
def test_of_all_moves_between_free_cells_only_those_exist_that_are_given(data: st.DataObject, h: int, w: int) -> None:
    free, in_rows, in_columns = (data.draw(masks(*shape)) for shape in ((h, w), (h, w - 1), (h - 1, w)))
    roadmap = Roadmap.of_moves(free, in_rows, in_columns)
    expected: dict[int, set[int]] = {cell: set() for cell in range(len(roadmap))}
    for exists, (down, right) in ((in_rows, (0, 1)), (in_columns, (1, 0))):
        for row, column in np.argwhere(exists & free[: h - down, : w - right] & free[down:, right:]):
            here, there = int(roadmap.numbers[row, column]), int(roadmap.numbers[row + down, column + right])
            expected[here].add(there)
            expected[there].add(here)
    for cell, own in enumerate(roadmap.neighbours):
        count = len(expected[cell])
        assert set(own[:count].tolist()) == expected[cell]
        assert (own[count:] == -1).all()


def masks(height: int, width: int) -> st.SearchStrategy[NDArray[np.bool_]]:
    size = height * width
    return st.lists(st.booleans(), min_size=size, max_size=size).map(
        lambda bits: np.array(bits, np.bool_).reshape(height, width)
    )


@pytest.mark.parametrize(
    ("place", "text"),
    [
        ((0, 1), "the goal of robot 1, row 0 column 1, is blocked"),
        ((2, 0), "is outside the map of 2 rows and 2 columns"),
        ((0, -1), "is outside"),
    ],
)
def test_a_place_where_no_robot_may_stand_is_named(place: tuple[int, int], text: str) -> None:
    roadmap = Roadmap.of_grid(np.array([[True, False], [True, True]]))
    with pytest.raises(InvalidInput, match=text):
        roadmap.at(np.array([(0, 0), place]), "goal")


def floor_for(floor: Floor, radius: float, margin: float = 0.02) -> MetricFloor:
    """Return a floor for robots of a radius; floors on which none fits are skipped."""
    try:
        return MetricFloor(*floor, lattice_roadmap(*floor, RobotSizes(radius, margin)), radius)
    except InvalidInput:
        assume(False)
        raise


@given(floors(turned=True), st.sampled_from([0.05, 0.15]), st.data())
def test_plans_between_places_beside_the_cells_are_valid(floor: Floor, radius: float, data: st.DataObject) -> None:
    made = floor_for(floor, radius)
    metric, size = made.metric, len(made.metric.roadmap)
    count = data.draw(st.integers(1, min(4, size)))
    starts, goals = (metric.centres[data.draw(st.permutations(range(size)))[:count]] for _ in range(2))
    aside = data.draw(st.floats(-0.2, 0.2)) * 0.02
    try:
        problem = made.problem(starts + aside, goals - aside)
        plan = first_plan(problem)
    except (InvalidInput, PlanningError):
        assume(False)
        raise
    for cells, places in ((problem.starts, starts), (problem.goals, goals)):
        assert np.hypot(*(metric.centres[cells] - places).T).max() <= WITHIN * metric.spacing
    improvement, left = Improvement(problem, plan), iter(range(20))
    improvement.run(lambda: next(left, None) is not None)
    for each in (plan, improvement.plan()):
        assert faults_of(metric.roadmap, each, problem.starts.tolist(), problem.goals.tolist()) == []
        for places in metric.centres[each.steps]:
            apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1)) + np.eye(count) * 1e9
            assert apart.min() >= 2 * (radius + 0.02) - 1e-9


def test_robots_times_cells_are_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    made = floor_for(floor_of(np.zeros((20, 30), np.bool_)), 0.2)
    monkeypatch.setattr(metric_roadmap, "MOST_DISTANCES", 2 * len(made.metric.roadmap) - 1)
    places = made.metric.centres[:2]
    with pytest.raises(InvalidInput, match=r"2 robots on \d+ cells are too many: .*; plan for fewer robots"):
        made.problem(places, places)
