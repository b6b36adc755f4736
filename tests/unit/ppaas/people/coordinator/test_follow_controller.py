"""Orders to follow people, over time: when a robot that does not see the person hands over."""

import pytest

from ppaas.people.coordinator.follow_controller import FollowController, Scene
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
    found.update(Scene(now, [1], {1: seen_by}, {1: costs}, {1}, ROBOTS, ROBOTS, following))
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
