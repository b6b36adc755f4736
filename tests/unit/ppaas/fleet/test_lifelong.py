"""Lifelong plans: their steps are valid, all goals are reached, and none stays open for ever."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.fleet.checking import faults_of
from ppaas.errors import InvalidInput
from ppaas.fleet.lifelong import LifelongPlan
from ppaas.fleet.plan import FleetPlan
from ppaas.fleet.roadmap import Roadmap
from tests.support.fleet.halls import Hall, hall_of, halls, ruled_halls


@given(halls(most_cells=20, most_robots=8) | ruled_halls(most_cells=20, most_robots=8), st.integers(0, 1000))
def test_all_steps_are_valid(hall: Hall, seed: int) -> None:
    plan = LifelongPlan(hall.roadmap, np.array(hall.starts, np.int32), seed)
    steps = [plan.cells]
    for robot, goal in enumerate(hall.goals):
        plan.set_goal(robot, goal)
        steps.append(plan.extend())
    whole = FleetPlan(np.array(steps), 0)
    assert faults_of(hall.roadmap, whole, hall.starts, plan.cells.tolist()) == []


def test_no_goal_stays_open_for_ever_among_robots_that_always_get_new_ones() -> None:
    free = np.ones((12, 12), np.bool_)
    free[2:10:3, 1:11] = False
    roadmap, rng = Roadmap.of_grid(free), np.random.default_rng(1)
    plan = LifelongPlan(roadmap, rng.choice(len(roadmap), 30, False).astype(np.int32), 1)
    reached, longest = np.zeros(30, np.int64), 0
    for _ in range(3000):
        for robot in np.nonzero(plan.cells == plan.goals)[0]:
            reached[robot] += 1
            plan.set_goal(int(robot), int(rng.integers(len(roadmap))))
        plan.extend()
        longest = max(longest, int(plan.ages.max()))
    assert reached.min() > 20
    assert longest < 20 * 3000 * 30 / reached.sum(), "without help, one waits for 900 steps"


def test_a_robot_without_a_goal_gives_way() -> None:
    hall = hall_of("a.bA\n##B#")
    plan = LifelongPlan(hall.roadmap, np.array(hall.starts, np.int32))
    plan.set_goal(0, hall.goals[0])
    arrived = [bool(plan.extend()[0] == hall.goals[0]) for _ in range(60)]
    assert any(arrived)


def test_ages_and_ways_of_goals() -> None:
    hall = hall_of("a..#A")
    plan = LifelongPlan(hall.roadmap, np.array(hall.starts, np.int32))
    assert plan.ages.tolist() == [0]
    plan.set_goal(0, hall.goals[0])
    plan.extend()
    plan.extend()
    assert (plan.can_reach(0), plan.ages.tolist()) == (False, [2])
    plan.set_goal(0, int(plan.cells[0]))
    assert (plan.can_reach(0), plan.ages.tolist()) == (True, [0])


def test_a_goal_that_has_been_open_in_another_plan_goes_first() -> None:
    hall = hall_of("Ba...bA")
    for old in (0, 1):
        plan = LifelongPlan(hall.roadmap, np.array(hall.starts, np.int32))
        for robot in (0, 1):
            plan.set_goal(robot, int(hall.goals[robot]), age=5 if robot == old else 0)
        assert plan.ages[old] == 5
        for _ in range(4):
            cells = plan.extend()
        apart = np.abs(cells - np.array(hall.goals))
        assert apart[old] < apart[1 - old], "it goes on, and the other gives way"


def test_two_robots_in_one_cell_are_refused() -> None:
    hall = hall_of("aA.")
    with pytest.raises(InvalidInput, match="same cell"):
        LifelongPlan(hall.roadmap, np.array([0, 0], np.int32))
