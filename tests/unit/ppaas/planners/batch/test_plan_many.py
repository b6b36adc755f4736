import itertools

import numpy as np
import pytest

from ppaas.costmap.costmap import Costmap
from ppaas.errors import GoalOccupied, InvalidInput, NoValidPath, PlanCancelled, PlanningError, PlanTimeout
from ppaas.geometry import Pose2D
from ppaas.planners import PlanRequest, create, planner_names
from ppaas.planners.batch import plan_many as module
from ppaas.planners.batch.plan_many import plan_many
from ppaas.planners.grid.dijkstra import Dijkstra
from ppaas.planners.prepared import Prepared, PreparedPlanner
from tests.support.world import grids


@pytest.fixture(scope="module")
def scene():
    """Return a map and requests: some share goals, some have no path."""
    rng = np.random.default_rng(1)
    costs = rng.choice(np.array([0, 80, 253, 254], np.uint8), (50, 60), p=[0.6, 0.2, 0.1, 0.1])
    map_ = grids.of(costs, 0.1)
    cells = rng.permutation(np.argwhere(costs < 254))
    goals = [*cells[:6], np.argwhere(costs == 254)[0]]
    ends = [(cells[6 + n], goals[n % 7]) for n in range(40)]
    return map_, [PlanRequest(grids.centre(map_, *start), grids.centre(map_, *goal)) for start, goal in ends]


def same(one, other):
    if isinstance(one, PlanningError):
        return type(one) is type(other) and str(one) == str(other)
    return np.array_equal(one.cells, other.cells) and np.array_equal(one.poses, other.poses) and one.cost == other.cost


def alone(planner, map_, request):
    try:
        return planner.plan(map_, request)
    except PlanningError as error:
        return error


@pytest.mark.parametrize("threads", [1, 2, 3])
@pytest.mark.parametrize("name", ["dijkstra", "astar", "navfn"])
def test_each_answer_equals_that_of_a_single_plan_on_any_threads(scene, name, threads):
    map_, requests = scene
    answers = plan_many(create(name), map_, requests, threads=threads)
    expected = [alone(create(name), map_, request) for request in requests]
    assert all(map(same, answers, expected))
    assert {type(each) for each in expected} >= {GoalOccupied}
    assert any(not isinstance(each, PlanningError) for each in expected)
    assert all(answer.planner == name for answer in answers if not isinstance(answer, PlanningError))


def test_each_answer_equals_that_of_a_single_plan_for_every_planner():
    map_ = grids.of(np.zeros((12, 12), np.uint8))
    requests = [PlanRequest(Pose2D(1.5, 1.5), Pose2D(9.5, n + 0.5)) for n in range(2, 6)]
    for name in planner_names():
        if create(name).traits.dimensions == 2:
            answers = plan_many(create(name), map_, requests, threads=2)
            assert all(map(same, answers, [alone(create(name), map_, request) for request in requests]))


def test_one_field_is_grown_for_all_requests_of_a_goal(scene, monkeypatch):
    grown = []

    class Counted(module.CostField):
        def __init__(self, *arguments, **known):
            grown.append(known["threads"])
            super().__init__(*arguments, **known)

    monkeypatch.setattr(module, "CostField", Counted)
    map_, requests = scene
    plan_many(Dijkstra(), map_, requests, threads=2)
    assert grown == [1] * 6
    plan_many(Dijkstra(), map_, requests[1::7], threads=2)
    assert grown[6:] == [2]


class Counting(PreparedPlanner):
    """Planner that counts its preparations, which do nothing."""

    name = "counting"
    purpose = "for this test"
    prepared_times = itertools.count()

    class Straight(Prepared):
        nbytes = 0

        def path(self, start_row, start_column, goal_row, goal_column, check=lambda: None):
            return np.array([(start_row, column) for column in range(start_column, goal_column + 1)], np.int32)

        def twin(self):
            return type(self)()

    def prepare(self, costmap, *, threads=1, check=lambda: None):
        next(self.prepared_times)
        return self.Straight()


def test_prepared_planner_prepares_a_writable_map_once():
    map_ = grids.costmap("..........")
    requests = [PlanRequest(Pose2D(0.5, 0.5), Pose2D(n + 0.5, 0.5)) for n in range(1, 10)]
    answers = plan_many(Counting(), map_, requests, threads=3)
    assert next(Counting.prepared_times) == 1
    assert [len(answer.cells) for answer in answers] == list(range(2, 11))


def test_the_preparation_of_a_writable_map_is_not_kept():
    map_, planner = grids.costmap(".........."), Counting()
    request = PlanRequest(Pose2D(0.5, 0.5), Pose2D(3.5, 0.5))
    plan_many(planner, map_, [request])
    before = next(Counting.prepared_times)
    planner.plan(map_, request)
    assert next(Counting.prepared_times) == before + 2


def test_progress_counts_the_answers(scene):
    map_, requests = scene
    reports = []
    plan_many(
        create("astar"), map_, requests[:5], threads=2, progress=lambda done, total: reports.append((done, total))
    )
    assert reports == [(n, 5) for n in range(1, 6)]
    reports.clear()
    plan_many(create("dijkstra"), map_, requests, progress=lambda done, total: reports.append((done, total)))
    assert len(reports) == 7
    assert reports[-1] == (40, 40)


def test_each_request_has_its_own_timeout_and_cancel_checker(scene):
    map_, requests = scene
    ticks = itertools.count()
    hurried = PlanRequest(requests[1].start, requests[1].goal, timeout=0.5, clock=lambda: float(next(ticks)))
    unwanted = PlanRequest(requests[2].start, requests[2].goal, cancelled=lambda: True)
    answers = plan_many(create("dijkstra"), map_, [requests[0], hurried, unwanted, requests[0]], threads=2)
    assert isinstance(answers[1], PlanTimeout)
    assert isinstance(answers[2], PlanCancelled)
    assert same(answers[0], answers[3])


def test_interrupted_plan_does_not_affect_the_next_to_its_goal(monkeypatch):
    monkeypatch.setattr("ppaas.planners.field.tile_field.SLICE_LINES", 1)
    map_ = grids.of(np.zeros((600, 600), np.uint8))
    start, goal = Pose2D(0.5, 0.5), Pose2D(599.5, 599.5)
    calls = itertools.count()
    interrupted = PlanRequest(start, goal, cancelled=lambda: next(calls) > 4)
    answers = plan_many(create("dijkstra"), map_, [interrupted, PlanRequest(start, goal)])
    assert isinstance(answers[0], PlanCancelled)
    assert answers[1].cost == pytest.approx(599 * 50.0 * np.sqrt(2.0))


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("error", [PlanCancelled("enough"), InvalidInput("enough")])
def test_error_of_the_check_ends_all_plans(scene, threads, error):
    calls = itertools.count()

    def check():
        if next(calls) > 20:
            raise error

    map_, requests = scene
    with pytest.raises(type(error), match="enough"):
        plan_many(create("astar"), map_, requests, threads=threads, check=check)


def test_an_invalid_request_is_refused_by_number_before_planning(scene):
    map_, requests = scene
    wrong = PlanRequest(Pose2D(float("nan"), 0.0), Pose2D(1.0, 1.0))
    with pytest.raises(InvalidInput, match="request 3: the start must be finite"):
        plan_many(create("dijkstra"), map_, [*requests[:3], wrong], progress=lambda *_: pytest.fail("was begun"))
    with pytest.raises(InvalidInput, match="threads must be at least 1"):
        plan_many(create("dijkstra"), map_, requests, threads=0)


def test_no_requests_give_no_answers():
    assert plan_many(create("dijkstra"), grids.costmap("."), []) == []


def test_a_missing_path_is_an_answer():
    map_ = Costmap(np.array([[0, 254, 0]], np.uint8), grids.costmap("...").info)
    answers = plan_many(create("dijkstra"), map_, [PlanRequest(Pose2D(0.5, 0.5), Pose2D(2.5, 0.5))])
    assert isinstance(answers[0], NoValidPath)
