"""Robots of several sizes: none enters a cell in which it has no room, and plans exist when a slow twin finds one."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from benchmarks.fleet.checking import faults_of
from ppaas.errors import GoalOccupied, InvalidInput, NoValidPath
from ppaas.fleet.first_plan import ConfigurationSearch
from ppaas.fleet.kernels.board import NO_GUIDE
from ppaas.fleet.lattice_roadmap import lattice_roadmap
from ppaas.fleet.lifelong import LifelongPlan
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.fleet.plan import FleetPlan
from ppaas.fleet.problem import board_of, distances_from
from ppaas.fleet.robot_sizes import RobotSizes
from tests.reference.fleet.searches import shortest
from tests.support.budget import examples
from tests.support.fleet.floors import Floor, floor_of, floors
from tests.support.fleet.halls import Hall, hall_of, mixed_halls


def enters_no_barred_cell(hall: Hall, sizes: NDArray[np.int8], steps: NDArray[np.int32]) -> bool:
    """Return whether no robot goes into a cell from another one in which it has room."""
    moves = steps[1:] != steps[:-1]
    return not (hall.roadmap.barred[sizes, steps[1:]] & moves).any()


@given(mixed_halls(most_cells=20, most_robots=8), st.integers(0, 1000))
def test_all_steps_of_a_lifelong_plan_are_valid(mixed: tuple[Hall, NDArray[np.int8]], seed: int) -> None:
    hall, sizes = mixed
    plan = LifelongPlan(hall.roadmap, np.array(hall.starts, np.int32), seed, sizes)
    steps = [plan.cells]
    for robot, goal in enumerate([*hall.goals, *hall.goals]):
        plan.set_goal(robot % len(sizes), goal)
        steps += [plan.extend() for _ in range(6)]
    whole = FleetPlan(np.array(steps), 0)
    assert faults_of(hall.roadmap, whole, hall.starts, plan.cells.tolist()) == []
    assert enters_no_barred_cell(hall, sizes, whole.steps)


@settings(max_examples=examples(100))
@given(mixed_halls(), st.integers(0, 100))
def test_there_is_a_plan_if_and_only_if_a_search_over_all_robots_finds_one(
    mixed: tuple[Hall, NDArray[np.int8]], seed: int
) -> None:
    hall, sizes = mixed
    starts, goals = np.array(hall.starts, np.int32), np.array(hall.goals, np.int32)
    of_size = [hall.roadmap.for_size(size) for size in sizes]
    distances = np.concatenate([distances_from(own, goals[[k]]) for k, own in enumerate(of_size)])
    board = board_of(hall.roadmap, distances, NO_GUIDE, goals, sizes)
    search = ConfigurationSearch(board, starts, np.ones(len(starts), np.bool_), seed)
    least = shortest(hall.roadmap, hall.starts, hall.goals, sizes.tolist())
    if least is None:
        with pytest.raises(NoValidPath):
            search.run(lambda: None)
        return
    steps = search.run(lambda: None)
    assert faults_of(hall.roadmap, FleetPlan(steps, 0), hall.starts, hall.goals) == []
    assert enters_no_barred_cell(hall, sizes, steps) and len(steps) > least


def test_a_small_robot_goes_around_a_large_one_through_a_narrow_lane() -> None:
    hall = hall_of("ab.BA\n.###.\n.....")
    narrow = hall.roadmap.cells[:, 0] > 0
    roadmap = replace(hall.roadmap, barred=np.stack([np.zeros_like(narrow), narrow]))
    plan = LifelongPlan(roadmap, np.array(hall.starts, np.int32), 0, np.array([0, 1], np.int8))
    plan.set_goal(0, hall.goals[0])
    plan.set_goal(1, hall.starts[0])
    steps = np.array([plan.extend() for _ in range(40)])
    assert (steps[:, 0] == hall.goals[0]).any() and (steps[:, 1] == hall.starts[0]).any()
    assert not narrow[steps[:, 1]].any()


@given(floors(), st.sampled_from([0.05, 0.1]), st.sampled_from([0.2, 0.3]), st.sampled_from([0.0, 0.05]))
def test_cells_of_each_size_have_room_for_it(floor: Floor, small: float, large: float, margin: float) -> None:
    try:
        metric = lattice_roadmap(*floor, RobotSizes(large, margin, smaller=(small, large)))
    except InvalidInput as error:
        assume("fits nowhere" not in str(error))
        raise
    alone = lattice_roadmap(*floor, RobotSizes(large, margin))
    assert (metric.radii, metric.spacing) == ((small, large), alone.spacing)
    assert [metric.size_of(radius) for radius in (0.01, small, small + 0.01, large, 1.0)] == [0, 0, 1, 1, 1]
    for size, radius in enumerate(metric.radii):
        for cell, (x, y) in enumerate(metric.centres.tolist()):
            place = floor.info.cell_of(x, y)
            room = 0.0 if place is None else float(floor.to_lethal[place])
            assert metric.roadmap.barred[size, cell] == (room < np.float32(radius + margin))
    large_ones = {tuple(centre) for centre in metric.centres[~metric.roadmap.barred[1]].round(6).tolist()}
    assert large_ones == {tuple(centre) for centre in alone.centres.round(6).tolist()}


def test_goals_are_in_cells_in_which_a_robot_has_room() -> None:
    metric, narrow = with_narrow_lane()
    x, y = metric.centre(narrow[-1])
    assert metric.nearest(x, y, 0.1, 0) == narrow[-1]
    with pytest.raises(GoalOccupied):
        metric.nearest(x, y, 0.1, 1)
    assert metric.nearby(x, y, 0.1, 0) == [narrow[-1]] and not metric.nearby(x, y, 0.1, 1)


def with_narrow_lane() -> tuple[MetricRoadmap, list[int]]:
    """Return the roadmap of a hall with a lane for small robots, and the cells of the lane."""
    for row in range(10, 24):
        lethal = np.zeros((40, 60), np.bool_)
        lethal[:, 20:] = True
        lethal[row : row + 4, 20:] = False
        metric = lattice_roadmap(*floor_of(lethal), RobotSizes(0.3, 0.0, smaller=(0.1,)))
        narrow = np.nonzero(metric.roadmap.barred[1] & (metric.centres[:, 0] > 2.5))[0].tolist()
        if len(narrow) > 3:
            return metric, narrow
    raise AssertionError("no lane has a row of cells")
