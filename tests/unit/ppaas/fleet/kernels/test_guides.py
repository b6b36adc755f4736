"""Distances and guides, the cheapest ways among those before, are as their slow twins find them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from ppaas.fleet.kernels import distances as module
from ppaas.fleet.kernels.board import UNREACHABLE
from ppaas.fleet.kernels.guides import guide_some, traffic_of
from ppaas.fleet.problem import FleetProblem, distances_from
from tests.reference.fleet.searches import GuidedWays, distances
from tests.support.fleet.halls import Hall, halls, ruled_halls


def reachable_part(hall: Hall) -> FleetProblem:
    """Return the problem of the robots that can reach their goals."""
    distances = distances_from(hall.roadmap, np.array(hall.goals, np.int32))
    able = distances[np.arange(len(hall.goals)), hall.starts] < UNREACHABLE
    starts, goals = hall.places()
    return FleetProblem.of(hall.roadmap, starts[able], goals[able])


def way_of(problem: FleetProblem, guide: NDArray[np.int8], robot: int) -> list[int]:
    """Return the cells from the start of a robot along its guide."""
    way = [int(problem.starts[robot])]
    while guide[robot, way[-1]] >= 0:
        way.append(int(problem.roadmap.neighbours[way[-1], guide[robot, way[-1]]]))
    return way


@given(halls(most_robots=5) | ruled_halls(most_robots=5), st.integers(0, 20), st.integers(0, 5))
def test_guides_are_the_cheapest_ways_among_those_before(hall: Hall, against: int, crowd: int) -> None:
    problem = reachable_part(hall)
    guide = np.full(problem.distances.shape, -1, np.int8)
    board, traffic = problem.board(guide), traffic_of(hall.roadmap.neighbours)
    twin = GuidedWays(hall.roadmap, against, crowd)
    for robot, goal in enumerate(problem.goals):
        guide_some(board, traffic, problem.starts, np.array([robot], np.int32), against, crowd, robot + 1)
        way = way_of(problem, guide, robot)
        assert way[-1] == goal
        assert twin.cost_of(way) == twin.least_cost(way[0], int(goal))
        twin.add(way)


@given(halls(most_cells=30) | ruled_halls(most_cells=30))
def test_distances_are_the_numbers_of_moves(hall: Hall) -> None:
    found = distances_from(hall.roadmap, np.array(hall.goals, np.int32))
    assert found.tolist() == [distances(hall.roadmap, goal) for goal in hall.goals]


def test_a_distance_that_does_not_fit_is_told() -> None:
    cells = int(UNREACHABLE) + 1
    neighbours = np.full((cells, 4), -1, np.int32)
    neighbours[:, 0], neighbours[:, 1] = np.arange(cells) - 1, np.arange(cells) + 1
    neighbours[0] = [1, -1, -1, -1]
    neighbours[-1, 1] = -1
    out, queue = np.empty(cells, np.int16), np.empty(cells, np.int32)
    assert not module.flood(neighbours, 0, out, queue)
    assert module.flood(neighbours, 1, out, queue)
    assert out.max() == UNREACHABLE - 1
