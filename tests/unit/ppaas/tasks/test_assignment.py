"""Tasks go to the robots that are cheapest together, and change hands only if it pays."""

from itertools import combinations, permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from ppaas.tasks.assignment import (
    MARGIN,
    MOST_TASKS,
    PRIORITY,
    URGENT,
    Array,
    TaskRobot,
    assign,
    cheapest,
    worth,
)
from ppaas.tasks.reach import SPEED, straight
from ppaas.tasks.records import Task

costs = arrays(
    np.float64, array_shapes(min_dims=2, max_dims=2, max_side=6), elements=st.sampled_from([*range(-5, 30), np.inf])
)
places = st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.just(0.0))


def task(name: str, x: float = 0.0, **fields: object) -> Task:
    return Task(id=name, kind="go_to", places=((x, 0.0, 0.0),), **fields)  # type: ignore[arg-type]


def robot(name: str, x: float = 0.0, **fields: object) -> TaskRobot:
    return TaskRobot(name, (x, 0.0, 0.0), **fields)  # type: ignore[arg-type]


def naive(matrix: Array) -> tuple[int, float]:
    """Return the number of pairs and the sum of costs of the best choice among all of them."""
    if matrix.shape[0] > matrix.shape[1]:
        return naive(matrix.T)
    best = (0, 0.0)
    rows, columns = matrix.shape
    for size in range(1, rows + 1):
        for chosen in combinations(range(rows), size):
            for taken in permutations(range(columns), size):
                total = float(matrix[list(chosen), list(taken)].sum())
                if np.isfinite(total) and (size > best[0] or total < best[1]):
                    best = (size, total)
    return best


@given(costs)
def test_the_cheapest_pairs_are_those_of_a_search_through_all(matrix: Array) -> None:
    pairs = cheapest(matrix)
    assert len({row for row, _ in pairs}) == len({column for _, column in pairs}) == len(pairs)
    number, total = naive(matrix)
    assert len(pairs) == number
    assert sum(matrix[pair] for pair in pairs) == pytest.approx(total)


@given(st.lists(places, max_size=5), st.lists(places, max_size=5), st.data())
def test_a_second_look_changes_nothing(
    starts: list[tuple[float, ...]], ends: list[tuple[float, ...]], data: st.DataObject
) -> None:
    robots = [TaskRobot(f"r{number}", start) for number, start in enumerate(starts)]  # type: ignore[arg-type]
    ages = data.draw(st.lists(st.floats(0, 500), min_size=len(ends), max_size=len(ends)))
    tasks = [
        Task(id=f"t{number}", kind="go_to", places=(end,), created=age)  # type: ignore[arg-type]
        for number, (end, age) in enumerate(zip(ends, ages, strict=True))
    ]
    found = assign(robots, tasks, straight, 500.0)
    assert len(found) == len(set(found.values())) == min(len(robots), len(tasks))
    again = [Task(id=one.id, kind=one.kind, places=one.places, created=one.created, robot=found.get(one.id, ""))
             for one in tasks]  # fmt: skip
    assert assign(robots, again, straight, 500.0) == found


def test_robots_go_to_the_tasks_that_are_nearest_together() -> None:
    found = assign([robot("a", 0.0), robot("b", 10.0)], [task("near", 9.0), task("far", 12.0)], straight, 0.0)
    assert found == {"near": "a", "far": "b"}


def test_a_robot_must_have_the_labels_of_a_task() -> None:
    robots = [robot("a"), robot("b", 50.0, labels={"lift": "yes"})]
    assert assign(robots, [task("t", labels={"lift": "yes"})], straight, 0.0) == {"t": "b"}
    assert assign(robots[:1], [task("t", labels={"lift": "yes"})], straight, 0.0) == {}


def test_tasks_of_a_higher_priority_go_first_until_others_have_waited() -> None:
    tasks = [task("low", 1.0), task("high", 20.0, priority=1)]
    assert assign([robot("a")], tasks, straight, 0.0) == {"high": "a"}
    later = [task("low", 1.0), task("high", 1.0, priority=1, created=PRIORITY + 1.0)]
    assert assign([robot("a")], later, straight, PRIORITY + 1.0) == {"low": "a"}


def test_tasks_are_worth_more_as_their_deadline_comes_near() -> None:
    due = task("due", deadline=URGENT + 100.0)
    assert worth(due, 50.0) == worth(task("other"), 50.0)
    assert worth(due, 200.0) > worth(task("other"), 200.0)


def test_a_task_changes_hands_only_if_that_pays() -> None:
    for saved, taken in ((0.5 * MARGIN, "a"), (1.5 * MARGIN, "b")):
        robots = [robot("a", 100.0), robot("b", 100.0 - saved * SPEED)]
        assert assign(robots, [task("t", robot="a")], straight, 0.0) == {"t": taken}


def test_a_task_waits_for_a_busy_robot_that_is_there_sooner() -> None:
    robots = [robot("far", 100.0), robot("busy", 1.0, remaining=20.0)]
    assert assign(robots, [task("t")], straight, 0.0) == {"t": "busy"}
    assert assign(robots, [task("t", robot="far")], straight, 0.0) == {"t": "far"}


def test_places_that_no_way_leads_to_are_nobodys() -> None:
    assert assign([robot("a")], [task("t")], lambda *_: np.inf, 0.0) == {}


def test_of_very_many_tasks_those_worth_most_are_considered() -> None:
    tasks = [task(f"t{number}", priority=number % 7) for number in range(3 * MOST_TASKS)]
    found = assign([robot(f"r{number}") for number in range(9)], tasks, straight, 0.0)
    assert all(int(name[1:]) % 7 == 6 for name in found)
