"""Guides are the cheapest ways among those of the robots before, as a slow twin finds them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from ppaas.fleet.kernels.board import UNREACHABLE
from ppaas.fleet.kernels.guides import guide_some, traffic_of
from ppaas.fleet.problem import FleetProblem, distances_from
from tests.reference.fleet.searches import GuidedWays
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
