"""Rules that choose whom robots follow."""

import pytest

from ppaas.errors import NotFound
from ppaas.people.rules.base import Candidate
from ppaas.people.rules.registry import create, rule_names

NEAR = Candidate(1, {"a": 100.0, "b": 300.0}, first_seen=50.0, seen_for=5.0)
FAR = Candidate(2, {"a": 200.0}, first_seen=10.0, seen_for=40.0)
UNSEEN = Candidate(3, {}, first_seen=5.0, seen_for=90.0)
PEOPLE = [NEAR, FAR, UNSEEN]


def test_the_installed_rules_are_those_of_the_project() -> None:
    assert {"longest_seen", "named", "nearest"} <= set(rule_names())


def test_nearest_takes_the_person_of_least_cost() -> None:
    assert create("nearest").choose(PEOPLE, [], 5) == [1, 2]
    assert create("nearest").choose(PEOPLE, [], 1) == [1]


def test_nearest_keeps_a_person_who_is_followed() -> None:
    followed = Candidate(2, {}, followed=True)
    assert create("nearest").choose([NEAR, followed], [], 1) == [2]


def test_named_takes_the_people_whom_a_user_picked_in_their_order() -> None:
    assert create("named").choose(PEOPLE, [3, 9, 1], 5) == [3, 1]
    assert create("named").choose(PEOPLE, [], 5) == []


def test_longest_seen_takes_the_person_whom_robots_saw_longest() -> None:
    assert create("longest_seen").choose(PEOPLE, [], 5) == [2, 1]


def test_every_rule_gives_a_reason() -> None:
    assert all(create(name).reason(NEAR) for name in rule_names())
    assert "Ann" in create("named").reason(Candidate(1, name="Ann"))


def test_an_unknown_rule_is_named_with_those_that_are_known() -> None:
    with pytest.raises(NotFound, match="nearest"):
        create("loudest")
