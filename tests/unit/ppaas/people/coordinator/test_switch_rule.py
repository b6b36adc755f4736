"""Step 5: switch to R′ only if R′'s cost is strictly decreasing over the observed history and smaller than R's."""

import math

from ppaas.people.coordinator.follow_controller import takes_over


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
