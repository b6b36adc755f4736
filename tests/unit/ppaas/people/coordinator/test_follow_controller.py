"""Orders to follow people, over time: when a robot that does not see the person hands over."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.people.coordinator.follow_controller import (
    FollowController,
    FollowScene,
    cheapest,
    follow_actions,
    takes_over,
)
from ppaas.people.coordinator.parameters import CoordinatorParameters

PARAMETERS = CoordinatorParameters()
PERIOD = 0.2
ROBOTS = {"a", "b"}


def controller() -> FollowController:
    """Return a controller whose robot a follows person 1."""
    found = FollowController(PARAMETERS)
    update(found, 0.0, {"a": 100.0, "b": 200.0}, {"a", "b"})
    assert found.orders[1].robot == "a"
    return found


def update(found: FollowController, now: float, costs: dict[str, float], seen_by: set[str]) -> str:
    following = {order.robot: order.person for order in found.orders.values()}
    found.update(FollowScene(now, [1], {1: seen_by}, {1: costs}, {1}, ROBOTS, ROBOTS, following))
    return found.orders[1].robot


def handover(found: FollowController, costs: dict[str, float]) -> float:
    """Return the time after which robot b gets the person whom it alone sees, at constant costs [s]."""
    for cycle in range(1, 100):
        if update(found, cycle * PERIOD, costs, {"b"}) == "b":
            return cycle * PERIOD
    raise AssertionError("robot a still follows")


def test_a_robot_that_does_not_see_the_person_hands_over_to_a_nearer_one_at_once():
    after = handover(controller(), {"a": 100.0, "b": 90.0})
    assert after == pytest.approx(PARAMETERS.lost_sight, abs=1.5 * PERIOD)


def test_a_robot_that_does_not_see_the_person_but_is_nearer_has_time_to_find_the_person():
    found = controller()
    after = handover(found, {"a": 100.0, "b": 110.0})
    assert after == pytest.approx(PARAMETERS.without_sight, abs=1.5 * PERIOD)
    assert "does not see the person" in found.orders[1].reason


def test_a_robot_without_a_path_hands_over_at_once():
    assert handover(controller(), {"b": 500.0}) == pytest.approx(PARAMETERS.lost_sight, abs=1.5 * PERIOD)


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


def test_another_robot_takes_over_if_its_cost_falls_strictly_and_is_smaller() -> None:
    assert takes_over(250.0, [400.0, 350.0, 300.0, 240.0], 4)


def test_a_smaller_cost_alone_is_not_enough() -> None:
    assert not takes_over(250.0, [240.0, 240.0, 240.0, 240.0], 4)
    assert not takes_over(250.0, [300.0, 200.0, 210.0, 190.0], 4)


def test_a_falling_cost_alone_is_not_enough() -> None:
    assert not takes_over(250.0, [400.0, 350.0, 300.0, 250.0], 4)


def test_a_history_that_is_too_short_is_not_enough() -> None:
    assert not takes_over(250.0, [300.0, 200.0], 4)


def test_only_the_observed_history_counts() -> None:
    assert takes_over(250.0, [100.0, 400.0, 350.0, 300.0, 240.0], 4)


def test_a_robot_that_has_no_path_any_more_hands_over_to_one_whose_cost_falls() -> None:
    assert takes_over(math.inf, [400.0, 350.0, 300.0, 299.0], 4)


def test_a_robot_without_a_path_does_not_take_over() -> None:
    assert not takes_over(math.inf, [400.0, 350.0, 300.0, math.inf], 4)
