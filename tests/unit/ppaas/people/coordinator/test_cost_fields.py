"""Costs of paths between robots and people: those of Dijkstra's planner, by few fields."""

import math

import numpy as np
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.people.coordinator.cost_fields import PathCosts, coarse
from ppaas.planners.batch.cost_matrix import cost_matrix
from tests.support.world.rooms import room

MAP = build_layers(room(12.0, 8.0)).costmap
ROBOTS = {"a": (2.0, 2.0), "b": (10.0, 6.0)}
PEOPLE = {1: (6.0, 4.0), 2: (9.0, 2.0), 3: (3.0, 6.0)}
ALL = {(robot, person) for robot in ROBOTS for person in PEOPLE}


def test_costs_are_those_of_plans_up_to_the_coarser_cells() -> None:
    paths = PathCosts(MAP, 10**7)
    paths.update(ROBOTS, PEOPLE, ALL, [])
    exact = cost_matrix(MAP, list(ROBOTS.values()), list(PEOPLE.values()))
    found = np.array([[paths.costs[robot, person] for person in PEOPLE] for robot in ROBOTS])
    assert found == pytest.approx(exact, rel=0.1)


def test_a_cycle_grows_as_many_fields_as_it_may_and_followed_people_come_first() -> None:
    paths = PathCosts(MAP, 1)
    assert paths.update(ROBOTS, PEOPLE, ALL, [3]) == {3}
    assert set(paths.costs) == {("a", 3), ("b", 3)}
    for _ in range(2):
        paths.update(ROBOTS, PEOPLE, ALL, [])
    assert set(paths.costs) == ALL


def test_of_many_followed_people_each_has_a_turn() -> None:
    paths = PathCosts(MAP, 1)
    assert [paths.update(ROBOTS, PEOPLE, ALL, [1, 2, 3]) for _ in range(4)] == [{1}, {2}, {3}, {1}]


def test_costs_of_pairs_that_are_not_wanted_are_forgotten() -> None:
    paths = PathCosts(MAP, 10**7)
    paths.update(ROBOTS, PEOPLE, ALL, [])
    paths.update(ROBOTS, PEOPLE, {("a", 1)}, [])
    assert set(paths.costs) == {("a", 1)}
    assert paths.by_person() == {1: {"a": paths.costs["a", 1]}}


def test_a_person_outside_the_map_has_no_path() -> None:
    paths = PathCosts(MAP, 10**7)
    paths.update(ROBOTS, {1: (50.0, 50.0)}, {("a", 1)}, [1])
    assert paths.costs == {("a", 1): math.inf}


def test_a_coarse_cell_is_blocked_if_any_of_its_cells_is() -> None:
    small, factor = coarse(MAP)
    assert (small.info.resolution, factor) == (pytest.approx(0.2), 4)
    height, width = (side // factor for side in MAP.info.shape)
    blocks = MAP.data.reshape(height, factor, width, factor).max(axis=(1, 3))
    assert ((small.data >= 253) == (blocks >= 253)).all()
