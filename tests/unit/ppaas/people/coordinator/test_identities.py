"""Step 3: identical persons recognized across robots, and the People Counter."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.people.coordinator.identities import NOBODY, Known, Torsos, people_counter, recognize
from ppaas.people.coordinator.parameters import CoordinatorParameters

PARAMETERS = CoordinatorParameters()
NOISE = 0.05**2


def torsos(*rows: tuple[int, float, float], deviation: float = 0.1, before: dict[int, int] | None = None) -> Torsos:
    """Return torsos of robot, x, y."""
    count = len(rows)
    return Torsos(
        np.array([robot for robot, _, _ in rows], np.intp),
        np.array([(x, y) for _, x, y in rows]).reshape(-1, 2),
        np.broadcast_to(NOISE * np.eye(2), (count, 2, 2)).copy(),
        np.full(count, deviation),
        np.array([(before or {}).get(k, NOBODY) for k in range(count)], np.intp),
    )


def known(*positions: tuple[float, float], hidden: float = 0.0, sigma: float = 0.05) -> Known:
    count = len(positions)
    spread = np.broadcast_to(sigma**2 * np.eye(2), (count, 2, 2)).copy()
    return Known(np.array(positions).reshape(-1, 2), spread, np.full(count, 0.1), np.full(count, hidden))


def test_two_robots_that_see_one_person_count_one() -> None:
    people = recognize(torsos((0, 3.0, 1.0), (1, 3.1, 1.1)), known(), PARAMETERS)
    assert people.tolist() == [0, 0]
    assert people_counter(people.tolist()) == 1


def test_two_torsos_of_one_robot_are_two_people_however_near() -> None:
    people = recognize(torsos((0, 3.0, 1.0), (0, 3.2, 1.0)), known(), PARAMETERS)
    assert people_counter(people.tolist()) == 2


def test_a_torso_is_the_known_person_within_the_gate() -> None:
    assert recognize(torsos((0, 3.1, 1.0)), known((9.0, 9.0), (3.0, 1.0)), PARAMETERS).tolist() == [1]


def test_a_torso_beyond_the_gate_is_a_new_person() -> None:
    assert recognize(torsos((0, 4.2, 1.0)), known((3.0, 1.0)), PARAMETERS).tolist() == [1]


def test_the_deviations_of_both_robots_widen_the_gate() -> None:
    assert recognize(torsos((0, 4.2, 1.0), deviation=0.9), known((3.0, 1.0)), PARAMETERS).tolist() == [0]


def test_the_assignment_is_global_and_not_the_nearest_first() -> None:
    seen = torsos((0, 3.25, 1.0), (0, 3.65, 1.0))
    assert recognize(seen, known((3.0, 1.0), (3.4, 1.0), sigma=0.1), PARAMETERS).tolist() == [0, 1]


def test_a_torso_stays_the_person_that_it_was_if_another_is_as_near() -> None:
    seen = torsos((0, 3.2, 1.0), before={0: 1})
    assert recognize(seen, known((3.0, 1.0), (3.4, 1.0)), PARAMETERS).tolist() == [1]


def test_an_id_that_a_robot_uses_again_for_somebody_else_is_a_new_person() -> None:
    assert recognize(torsos((0, 8.0, 8.0), before={0: 0}), known((3.0, 1.0)), PARAMETERS).tolist() == [1]


def test_a_person_who_was_hidden_is_known_again_where_a_walk_can_have_led() -> None:
    gone = known((3.0, 1.0), hidden=3.0, sigma=1.5)
    assert recognize(torsos((0, 5.5, 1.0)), gone, PARAMETERS).tolist() == [0]


def test_nobody_seen_is_nobody_counted() -> None:
    assert people_counter(recognize(torsos(), known((1.0, 1.0)), PARAMETERS).tolist()) == 0


@given(
    st.lists(st.tuples(st.integers(0, 2), st.integers(0, 9), st.integers(0, 9)), unique=True, max_size=9),
    st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), unique=True, max_size=5),
)
def test_the_count_is_between_the_most_of_one_robot_and_the_sum_of_all(
    seen: list[tuple[int, int, int]], people: list[tuple[int, int]]
) -> None:
    rows = sorted((robot, 0.5 * x, 0.5 * y) for robot, x, y in seen)
    found = recognize(torsos(*rows), known(*((0.5 * x, 0.5 * y) for x, y in people)), PARAMETERS).tolist()
    each = [[person for (robot, _, _), person in zip(rows, found, strict=True) if robot == r] for r in range(3)]
    assert all(len(set(persons)) == len(persons) for persons in each)
    assert max(map(len, each)) <= people_counter(found) <= len(rows)


def test_a_person_stays_where_one_robot_sees_them_if_another_loses_track() -> None:
    seen = torsos((0, 3.5, 1.0), (1, 3.0, 1.0), before={0: 0, 1: 0})
    assert recognize(seen, known((3.05, 1.0)), PARAMETERS).tolist() == [1, 0]


def test_two_people_between_whom_a_prediction_lies_do_not_stay_one() -> None:
    seen = torsos((0, 3.0, 1.0), (1, 3.9, 1.0), before={0: 0, 1: 0})
    assert len(set(recognize(seen, known((3.45, 1.0)), PARAMETERS).tolist())) == 2


@given(st.lists(st.tuples(st.integers(0, 3), *[st.floats(0.0, 0.9)] * 2), max_size=12), st.floats(0.0, 2.0))
def test_torsos_are_the_same_known_people_whichever_other_robots_report(
    rows: list[tuple[int, float, float]], hidden: float
) -> None:
    rows = sorted(rows)
    people = known((0.1, 0.1), (0.7, 0.2), (0.4, 0.8), hidden=hidden)  # so near that no torso is split off
    together = recognize(torsos(*rows, deviation=1.0), people, PARAMETERS).tolist()
    for robot in {robot for robot, _, _ in rows}:
        alone = recognize(torsos(*(row for row in rows if row[0] == robot), deviation=1.0), people, PARAMETERS)
        own = [person for person, row in zip(together, rows, strict=True) if row[0] == robot]
        assert [min(person, 3) for person in own] == np.minimum(alone, 3).tolist()
