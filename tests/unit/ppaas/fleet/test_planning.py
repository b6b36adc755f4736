"""Plans of fleets are valid, exist when a slow twin finds one, and only become better."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.fleet.checking import faults_of
from ppaas.errors import InvalidInput, NoValidPath, PlanCancelled
from ppaas.fleet.first_plan import first_plan, guide_of
from ppaas.fleet.improvement import MOST_TURN, Improvement, improved
from ppaas.fleet.kernels.board import UNREACHABLE
from ppaas.fleet.plan import FleetPlan, turns_of
from ppaas.fleet.problem import FleetProblem, distances_from
from ppaas.fleet.roadmap import Roadmap
from tests.reference.fleet.searches import shortest
from tests.support.budget import examples
from tests.support.fleet.halls import Hall, hall_of, halls, ruled_halls

HEAD_ON = """
    a....B
    ####.#
    A....b
    """
LANE = """
    #.####
    Ab..aB
    """
CROSSING = """
    ##a##
    ##.##
    b...B
    ##.##
    ##A##
    """


def problem_of(hall: Hall) -> FleetProblem:
    return FleetProblem.of(hall.roadmap, *hall.places())


def random_problem(seed: int, size: int, robots: int) -> FleetProblem:
    """Return a problem in a hall of which a fifth is blocked, all in one connected part."""
    rng = np.random.default_rng(seed)
    free = rng.random((size, size)) > 0.2
    free[size // 2] = True
    roadmap = Roadmap.of_grid(free)
    middle = roadmap.numbers[size // 2, :1]
    part = np.nonzero(distances_from(roadmap, middle)[0] < UNREACHABLE)[0]
    starts, goals = [roadmap.cells[rng.choice(part, robots, False)].astype(np.int64) for _ in range(2)]
    return FleetProblem.of(roadmap, starts, goals)


@settings(max_examples=examples(200))
@given(halls() | ruled_halls(), st.integers(0, 100))
def test_there_is_a_plan_if_and_only_if_a_search_over_all_robots_finds_one(hall: Hall, seed: int) -> None:
    least = shortest(hall.roadmap, hall.starts, hall.goals)
    if least is None:
        with pytest.raises(NoValidPath):
            first_plan(problem_of(hall), seed)
        return
    problem = problem_of(hall)
    plan = first_plan(problem, seed)
    assert faults_of(hall.roadmap, plan, hall.starts, hall.goals) == []
    assert plan.makespan >= least and plan.cost >= plan.bound == problem.bound


@pytest.mark.parametrize("drawing", [HEAD_ON, LANE, CROSSING])
def test_robots_pass_each_other(drawing: str) -> None:
    hall = hall_of(drawing)
    plan = first_plan(problem_of(hall))
    assert faults_of(hall.roadmap, plan, hall.starts, hall.goals) == []


@pytest.mark.parametrize(("size", "robots"), [(16, 100), (32, 60), (40, 200)])
def test_many_robots_and_the_improvement_of_their_plan(size: int, robots: int) -> None:
    problem = random_problem(size, size, robots)
    plan = first_plan(problem, 1)
    assert faults_of(problem.roadmap, plan, problem.starts.tolist(), problem.goals.tolist()) == []
    rounds = itertools.count()
    improvement = Improvement(problem, plan, 1)
    improvement.run(lambda: next(rounds) < 60)
    better = improvement.plan()
    assert faults_of(problem.roadmap, better, problem.starts.tolist(), problem.goals.tolist()) == []
    assert problem.bound <= better.cost == improvement.cost < plan.cost


def test_the_same_seed_gives_the_same_plan() -> None:
    problem = random_problem(3, 16, 60)
    one, same, other = (first_plan(problem, seed) for seed in (5, 5, 6))
    assert np.array_equal(one.steps, same.steps)
    assert not np.array_equal(one.steps, other.steps)


def test_guides_lead_from_starts_to_goals() -> None:
    problem = random_problem(4, 20, 80)
    guide = guide_of(problem, 1)
    for robot, (start, goal) in enumerate(zip(problem.starts, problem.goals, strict=True)):
        cell = start
        for _ in range(len(problem.roadmap)):
            if cell == goal:
                break
            assert guide[robot, cell] >= 0
            cell = problem.roadmap.neighbours[cell, guide[robot, cell]]
        assert cell == goal


def test_an_improvement_ends_at_the_bound() -> None:
    hall = hall_of("a..A\nb..B")
    problem = problem_of(hall)
    improvement = Improvement(problem, first_plan(problem))
    improvement.run(lambda: True)
    assert improvement.cost == problem.bound == 6


@pytest.mark.parametrize("turn", [0.3, 1.0, 50.0])
def test_an_improvement_turns_less_where_turns_cost_something(turn: float) -> None:
    problem = random_problem(32, 32, 60)
    plan, better = first_plan(problem, 1), list[FleetPlan]()
    for cost in (0.0, turn):
        rounds = itertools.count()
        improvement = Improvement(problem, plan, 1, cost)
        improvement.run(lambda rounds=rounds: next(rounds) < 60)
        better.append(improvement.plan())
        assert faults_of(problem.roadmap, better[-1], problem.starts.tolist(), problem.goals.tolist()) == []
    before, after = [int(turns_of(problem.roadmap, found).sum()) for found in better]
    assert after < before
    assert improvement.cost == pytest.approx(better[1].cost + min(turn, MOST_TURN) * after)


@pytest.mark.parametrize("turn", [0.0, 1.0])
def test_turns_count_in_the_last_part_of_the_time(turn: float) -> None:
    problem = random_problem(32, 32, 60)
    plan, rounds = first_plan(problem, 1), itertools.count()
    found = improved(problem, plan, 1, turn, lambda: next(rounds) / 60.0)
    assert next(rounds) > 60
    assert found.plan().cost < plan.cost
    assert faults_of(problem.roadmap, found.plan(), problem.starts.tolist(), problem.goals.tolist()) == []
    turns = int(turns_of(problem.roadmap, found.plan()).sum())
    assert found.cost == pytest.approx(found.plan().cost + turn * turns)
    rounds = itertools.count()
    plain = improved(problem, plan, 1, 0.0, lambda: next(rounds) / 60.0)
    assert turns < turns_of(problem.roadmap, plain.plan()).sum() or turn == 0.0


def test_no_robots_have_an_empty_plan() -> None:
    nothing = np.empty((0, 2), np.int64)
    plan = first_plan(FleetProblem.of(Roadmap.of_grid(np.ones((2, 2), np.bool_)), nothing, nothing))
    assert (plan.cost, plan.makespan, plan.steps.shape) == (0, 0, (1, 0))


def test_the_improvement_of_no_robots_ends_at_once() -> None:
    nothing = np.empty((0, 2), np.int64)
    problem = FleetProblem.of(Roadmap.of_grid(np.ones((2, 2), np.bool_)), nothing, nothing)
    improvement = Improvement(problem, first_plan(problem))
    improvement.run(lambda: True)
    assert improvement.cost == 0


@pytest.mark.parametrize(
    ("starts", "goals", "error", "text"),
    [
        ([(0, 0)], [(0, 1), (1, 1)], InvalidInput, "1 starts and 2 goals"),
        ([(0, 0), (0, 1), (0, 0)], [(0, 0), (0, 1), (1, 1)], InvalidInput, "the starts of robots 0 and 2 are the same"),
        ([(0, 0), (0, 1)], [(1, 1), (1, 1)], InvalidInput, "the goals of robots 0 and 1 are the same"),
        ([(0, 0)], [(3, 3)], NoValidPath, "robot 0 cannot reach its goal"),
        ([(2, 2)], [(0, 0)], InvalidInput, "the start of robot 0"),
    ],
)
def test_starts_and_goals_that_are_impossible(
    starts: list[tuple[int, int]], goals: list[tuple[int, int]], error: type[Exception], text: str
) -> None:
    free = np.zeros((4, 4), np.bool_)
    free[:2, :2] = free[3, 3] = True
    with pytest.raises(error, match=text):
        FleetProblem.of(Roadmap.of_grid(free), np.array(starts), np.array(goals))


def test_a_check_that_raises_ends_the_search() -> None:
    problem = random_problem(5, 16, 100)
    calls = itertools.count()

    def check() -> None:
        if next(calls) >= 1:
            raise PlanCancelled("cancelled")

    with pytest.raises(PlanCancelled):
        first_plan(problem, 1, check)
