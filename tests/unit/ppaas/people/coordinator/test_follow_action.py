"""Step 4: Follow Action Controller; the cheapest robot follows."""

import math

from hypothesis import given
from hypothesis import strategies as st

from ppaas.people.coordinator.follow_controller import cheapest, follow_actions


def test_the_cheapest_robot_follows() -> None:
    assert follow_actions([7], {7: {"a": 300.0, "b": 200.0}}, ["a", "b"]) == {7: "b"}


def test_a_robot_that_did_not_identify_the_person_does_not_follow() -> None:
    assert follow_actions([7], {7: {"b": 200.0}}, ["a"]) == {}


def test_a_robot_without_a_path_does_not_follow() -> None:
    assert cheapest({"a": math.inf}) is None
    assert follow_actions([7], {7: {"a": math.inf}}, ["a"]) == {}


def test_several_people_are_followed_at_the_least_total_cost() -> None:
    costs = {1: {"a": 100.0, "b": 150.0}, 2: {"a": 120.0, "b": 500.0}}
    assert follow_actions([1, 2], costs, ["a", "b"]) == {1: "b", 2: "a"}


def test_the_first_people_have_precedence_if_robots_are_few() -> None:
    costs = {1: {"a": 900.0}, 2: {"a": 100.0}}
    assert follow_actions([1, 2], costs, ["a"]) == {1: "a"}


def test_a_person_gives_way_to_nobody_but_takes_another_robot_if_that_lets_more_be_followed() -> None:
    costs = {1: {"a": 100.0, "b": 900.0}, 2: {"a": 100.0}}
    assert follow_actions([1, 2], costs, ["a", "b"]) == {1: "b", 2: "a"}


def test_equal_costs_are_decided_by_name() -> None:
    assert cheapest({"b": 1.0, "a": 1.0}) == "a"


@given(
    st.dictionaries(
        st.integers(1, 5), st.dictionaries(st.sampled_from("abcd"), st.floats(1.0, 1e6), max_size=4), max_size=5
    ),
    st.permutations("abcd"),
)
def test_no_robot_follows_two_people_and_the_order_of_robots_does_not_matter(costs, robots) -> None:  # type: ignore[no-untyped-def]
    people = sorted(costs)
    given = follow_actions(people, costs, list(robots))
    assert len(set(given.values())) == len(given)
    assert all(robot in costs[person] for person, robot in given.items())
    assert given == follow_actions(people, costs, "abcd")
