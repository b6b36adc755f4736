"""Score of counting and following people, from scripted truth and states."""

import json

import numpy as np
import pytest

from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import PREDICTED, FollowOrder, PeopleState, TrackedPerson
from robots.demo.people_score import ABSENCE, LAG, PeopleDemoReport, PeopleFigures, PeopleScore, Truth

AT = np.array([[1.0, 0.0], [5.0, 0.0]])


def state(*people: tuple[int, float], robot: str = "", person: int = 1) -> PeopleState:
    """Return a state: identities at x positions, and the robot that follows a person."""
    tracked = [
        TrackedPerson(identity, Point(x, 0.0), Point(0.0, 0.0), [0.01, 0.0, 0.0, 0.01]) for identity, x in people
    ]
    orders = [FollowOrder(robot, person, 1.0, Time())] if robot else []
    return PeopleState(Header(), len(tracked), tracked, orders)


def truth(time: float, *shares: float, people: np.ndarray = AT, robot: float = 0.0) -> Truth:
    return Truth(time, people, np.array(shares), {"a": (robot, 0.0), "b": (robot + 1.0, 0.0)})


def run(score: PeopleScore, begin: float, seconds: float, shares: tuple[float, float], told: PeopleState) -> None:
    for tick in range(round(seconds * 5)):
        score.take(truth(begin + tick / 5, *shares), told)


def test_a_right_count_of_people_in_view_is_exact_and_a_ghost_is_not() -> None:
    score = PeopleScore(2)
    run(score, 0.0, 4.0, (1.0, 1.0), state((1, 1.0), (2, 5.0), robot="a"))
    assert score.figures().count_exact == 1.0
    run(score, 4.0, 4.0, (1.0, 1.0), state((1, 1.0), (2, 5.0), (3, 9.0), robot="a"))
    figures = score.figures()
    assert (figures.count_exact, figures.count_error_mean, figures.ghosts) == (0.5, 0.5, 0.5)
    assert figures.seen == pytest.approx(2.0, abs=0.3)


def test_a_person_at_the_edge_of_the_views_may_be_counted_and_need_not_be() -> None:
    score = PeopleScore(2)
    run(score, 0.0, LAG, (1.0, 0.3), state((1, 1.0)))
    run(score, LAG, LAG, (1.0, 0.3), state((1, 1.0), (2, 5.0)))
    assert score.figures().count_exact == 1.0
    run(score, 2 * LAG, 4 * LAG, (1.0, 0.0), state((1, 1.0), (2, 5.0)))  # two of three are too late
    assert 0.4 < score.figures().count_exact < 0.6


def test_another_identity_in_view_is_a_switch_but_not_after_a_long_absence() -> None:
    score = PeopleScore(2)
    run(score, 0.0, 3.0, (1.0, 1.0), state((1, 1.0), (2, 5.0)))
    run(score, 3.0, 3.0, (1.0, 1.0), state((2, 1.0), (1, 5.0)))
    assert score.figures().identity_switches == 2
    run(score, 6.0, ABSENCE + 2.0, (0.0, 0.0), state())
    run(score, 8.0 + ABSENCE, 1.0, (0.3, 0.3), state())
    run(score, 9.0 + ABSENCE, 3.0, (1.0, 1.0), state((3, 1.0), (4, 5.0)))
    assert score.figures().identity_switches == 2


def test_another_identity_at_the_edge_of_the_views_is_no_switch() -> None:
    score = PeopleScore(2)
    run(score, 0.0, 3.0, (1.0, 1.0), state((1, 1.0), (2, 5.0)))
    run(score, 3.0, 3.0, (1.0, 0.3), state((1, 1.0), (3, 5.0)))
    run(score, 6.0, 3.0, (1.0, 1.0), state((1, 1.0), (2, 5.0)))
    assert score.figures().identity_switches == 0


def test_a_ghost_beside_people_takes_nobody_their_identity() -> None:
    score = PeopleScore(2)
    near = np.array([[1.0, 0.0], [1.8, 0.0]])
    for tick in range(30):
        score.take(truth(tick / 5, 1.0, 0.3, people=near), state((1, 1.0)))
    for tick in range(30, 60):
        score.take(truth(tick / 5, 1.0, 0.3, people=near), state((1, 1.0), (2, 0.4)))
    figures = score.figures()
    assert (figures.identity_switches, figures.ghosts) == (0, 0.5)


def test_an_identity_beside_a_person_in_view_is_not_of_one_at_the_edge_who_had_it() -> None:
    score = PeopleScore(2)
    near = np.array([[1.0, 0.0], [1.8, 0.0]])
    for tick in range(30):
        score.take(truth(tick / 5, 1.0, 0.0, people=near), state((1, 1.0)))
    for tick in range(30, 60):
        score.take(truth(tick / 5, 0.3, 1.0, people=near), state((1, 1.8)))
    for tick in range(60, 90):
        score.take(truth(tick / 5, 1.0, 1.0, people=near), state((2, 1.0), (1, 1.8)))
    assert score.figures().identity_switches == 1


def test_people_who_stand_together_and_swap_identities_switch_twice() -> None:
    score = PeopleScore(2)
    for tick in range(60):
        ids = (1, 2) if tick < 30 else (2, 1)
        score.take(
            truth(tick / 5, 1.0, 1.0, people=np.array([[1.0, 0.0], [1.8, 0.0]])), state((ids[0], 1.0), (ids[1], 1.8))
        )
    assert score.figures().identity_switches == 2


def test_a_hidden_person_at_a_predicted_position_is_not_a_ghost() -> None:
    score = PeopleScore(2)
    told = state((1, 1.0))
    told.people.append(TrackedPerson(2, Point(5.0, 0.0), Point(0.0, 0.0), [1.0, 0.0, 0.0, 1.0], state=PREDICTED))
    told.count = 1
    run(score, 0.0, 3.0, (1.0, 0.0), told)
    assert (score.figures().count_exact, score.figures().ghosts) == (1.0, 0.0)


def test_the_target_is_followed_while_a_robot_is_near() -> None:
    score = PeopleScore(2)
    run(score, 0.0, 1.0, (1.0, 0.0), state((1, 1.0), robot="a"))  # not yet in view
    for tick in range(20):
        score.take(truth(1.0 + tick / 5, 1.0, 0.0, robot=0.0 if tick < 5 else -4.0), state((1, 1.0), robot="a"))
    assert score.figures().followed_fraction == 0.25


def test_nobody_is_followed_while_there_is_no_order_though_a_person_is_in_view() -> None:
    score = PeopleScore(2)
    run(score, 0.0, 3.0, (1.0, 0.0), state((1, 1.0)))
    assert score.figures().followed_fraction == 0.0


def test_a_handover_that_is_reverted_within_five_seconds_is_a_flap() -> None:
    score = PeopleScore(2)
    for begin, robot in ((0.0, "a"), (3.0, "b"), (6.0, "a"), (20.0, "b")):
        run(score, begin, 3.0, (1.0, 0.0), state((1, 1.0), robot=robot))
    assert (score.figures().handovers, score.figures().flaps) == (3, 1)


GOOD = PeopleFigures(0.02, 0.98, 1, 0.97, 2, 0, 0, 1.5, 60.0)


def test_the_json_object_has_the_figures_only() -> None:
    report = PeopleDemoReport("office", 60.0, 3, 5, GOOD)
    assert json.loads(report.to_json()) == {
        "count_error_mean": 0.02,
        "count_exact": 0.98,
        "identity_switches": 1,
        "followed_fraction": 0.97,
        "handovers": 2,
        "flaps": 0,
        "contacts": 0,
    }


@pytest.mark.parametrize(
    ("change", "passed"),
    [
        ({}, True),
        ({"contacts": 1}, False),
        ({"flaps": 1}, False),
        ({"seen": 0.0}, False),
        ({"followed_fraction": 0.0}, False),
    ],
)
def test_a_demo_passes_if_people_are_followed_without_contacts_and_flaps(
    change: dict[str, float], passed: bool
) -> None:
    figures = PeopleFigures(**{**{name: getattr(GOOD, name) for name in GOOD.__struct_fields__}, **change})
    report = PeopleDemoReport("office", 60.0, 3, 5, figures)
    assert report.passed == passed
    text = "\n".join(report.lines())
    assert "98.0 % of the time" in text
    assert ("passed after 60 s" in text) == passed
