"""The check of plans finds each kind of fault."""

import numpy as np
import pytest

from benchmarks.fleet.checking import faults_of
from ppaas.fleet.plan import FleetPlan
from ppaas.fleet.roadmap import Roadmap

ROADMAP = Roadmap.of_grid(np.ones((2, 3), np.bool_))


@pytest.mark.parametrize(
    ("steps", "faults"),
    [
        ([[0, 5], [1, 4], [2, 3]], []),
        ([[0, 1], [1, 2]], []),
        ([[0, 1], [1, 1]], ["robots [0, 1] are in cell 1 at time 1"]),
        ([[0, 1], [1, 0]], ["robots exchange the cells [0, 1] at time 0"]),
        ([[0, 1, 4, 3], [1, 4, 3, 0]], ["robots exchange the cells [0, 1, 4, 3] at time 0"]),
        ([[0, 3], [2, 3]], ["robot 0 jumps at time 0"]),
        ([[2, 3], [3, 4]], ["robot 0 jumps at time 0"]),
        ([[0], [6]], ["a cell is not on the roadmap"]),
    ],
)
def test_faults(steps: list[list[int]], faults: list[str]) -> None:
    plan = FleetPlan(np.array(steps, np.int32), 0)
    if faults == ["a cell is not on the roadmap"]:
        assert faults[0] in faults_of(ROADMAP, plan, steps[0], [0])
    else:
        assert faults_of(ROADMAP, plan, steps[0], steps[-1]) == faults


def test_a_move_that_the_roadmap_lacks_is_a_jump() -> None:
    apart = Roadmap.of_moves(np.ones((1, 3), np.bool_), np.array([[True, False]]), np.ones((0, 3), np.bool_))
    plan = FleetPlan(np.array([[0], [1], [2]], np.int32), 0)
    assert faults_of(apart, plan, [0], [2]) == ["robot 0 jumps at time 1"]


def test_wrong_ends_and_shapes() -> None:
    plan = FleetPlan(np.array([[0, 1], [0, 2]], np.int32), 1)
    assert faults_of(ROADMAP, plan, [0, 4], [1, 2]) == [
        "robot 1 is not at its start",
        "robot 0 is not at its goal",
    ]
    assert "there are 3 robots" in faults_of(ROADMAP, plan, [0, 1, 2], [0, 1, 2])[0]


def test_costs_count_until_the_last_arrival() -> None:
    plan = FleetPlan(np.array([[0, 1], [3, 1], [0, 2], [0, 1]], np.int32), 0)
    assert plan.arrivals.tolist() == [2, 3]
    assert (plan.cost, plan.makespan) == (5, 3)
