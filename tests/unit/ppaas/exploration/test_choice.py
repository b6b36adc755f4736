"""Choice: near and large frontiers first, and no swinging between two."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidParameter
from ppaas.exploration.approaches import Approach
from ppaas.exploration.choice import choose, same_frontier, score
from ppaas.exploration.frontiers import Frontier
from ppaas.exploration.parameters import ChoiceParameters
from ppaas.geometry import Pose2D
from ppaas.maps.generate import office
from tests.support.world.exploring import Explorer, UnknownPlace

USUAL = ChoiceParameters()


def approach(distance: float, size: float = 1.0) -> Approach:
    return Approach(Frontier(np.zeros((1, 2), np.int64), size, 0.0), Pose2D(0.0, 0.0), np.zeros(2), distance)


ANY = st.builds(approach, st.floats(0.0, 100.0), st.floats(0.5, 50.0))


def test_nearer_and_larger_frontiers_are_preferred():
    near, far, large = approach(2.0), approach(3.0), approach(3.0, 4.0)
    assert choose([far, near], USUAL) is near
    assert choose([near, large], USUAL) is large
    assert choose([], USUAL) is None


def test_frontiers_that_other_robots_are_nearer_to_are_left_to_them():
    near, far = approach(2.0), replace(approach(5.0), seen=np.array([9.0, 0.0]))
    beside_near, away = np.array([[0.5, 0.0]]), np.array([[0.0, 30.0]])
    assert choose([near, far], USUAL, others=beside_near) is far
    assert choose([near, far], USUAL, others=away) is near
    assert choose([near], USUAL, others=beside_near) is near
    assert choose([near, far], ChoiceParameters(others_penalty=0.0), others=beside_near) is near


@given(st.lists(ANY, min_size=1, max_size=8), st.data())
def test_current_frontier_is_left_only_for_one_that_is_better_by_the_hysteresis(approaches, data):
    current = data.draw(st.sampled_from(approaches))
    chosen = choose(approaches, USUAL, current)
    assert chosen is current or score(chosen, USUAL) <= score(current, USUAL) - USUAL.hysteresis


def test_frontier_is_recognised_by_the_place_that_was_to_be_seen():
    first, second = approach(1.0), approach(2.0)
    points = [np.array([[0.0, 0.0], [0.0, 1.0]]), np.array([[5.0, 0.0]])]
    assert same_frontier([first, second], points, np.array([0.3, 1.0]), 0.5) is first
    assert same_frontier([first, second], points, np.array([4.8, 0.0]), 0.5) is second
    assert same_frontier([first, second], points, np.array([2.5, 0.0]), 0.5) is None
    assert same_frontier([], [], np.zeros(2), 0.5) is None


@pytest.mark.parametrize("wrong", [{"min_frontier_size": 0.0}, {"hysteresis": -1.0}, {"gain_scale": float("nan")}])
def test_parameters_are_checked(wrong):
    with pytest.raises(InvalidParameter, match=next(iter(wrong))):
        ChoiceParameters(**wrong)


def test_an_office_is_explored_to_the_end():
    world = office(2, 9.0, 10.0)
    explorer = Explorer(UnknownPlace(world, reach=6.0), Pose2D(4.5, 5.0))
    steps = 0
    while explorer.step(3.0):
        steps += 1
        assert steps < 150
    free = world.data == 0
    assert (explorer.place.known.data[free] == 0).mean() > 0.98
    assert explorer.targets < steps, "some targets are kept for several steps"
