"""Choice: near and large frontiers first, no swinging between two, and places that were given up."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidParameter
from ppaas.exploration import given_up
from ppaas.exploration.approaches import Approach
from ppaas.exploration.choice import choose, same_frontier, score
from ppaas.exploration.frontiers import Frontier
from ppaas.exploration.given_up import GivenUp
from ppaas.exploration.parameters import ChoiceParameters
from ppaas.geometry import Pose2D
from ppaas.maps.generate import office
from ppaas.planar_poses import moved_points
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


LINE = np.stack((np.linspace(1.0, 3.0, 40), np.full(40, 2.0)), axis=1)


def test_frontier_is_given_up_although_it_moves_a_little():
    places = GivenUp()
    assert not places.covers(LINE)
    places.add(LINE)
    assert places.covers(LINE)
    assert places.covers(LINE + 0.15)
    assert not places.covers(LINE + 2.0)


def test_frontier_that_has_grown_far_beyond_is_another():
    places = GivenUp()
    places.add(LINE)
    longer = np.stack((np.linspace(1.0, 9.0, 160), np.full(160, 2.0)), axis=1)
    assert not places.covers(longer)


def test_places_are_continued_from_their_tiles():
    places = GivenUp()
    places.add(LINE)
    assert GivenUp(places.tiles).covers(LINE)


def test_few_points_give_up_the_same_places():
    places = GivenUp()
    places.add(given_up.thinned(LINE))
    assert len(given_up.thinned(LINE)) < 10
    assert places.covers(LINE)


def test_oldest_places_are_forgotten(monkeypatch):
    monkeypatch.setattr(given_up, "MOST_TILES", 10)
    places = GivenUp()
    places.add(LINE)
    places.add(LINE + 50.0)
    assert len(places.tiles) == 10
    assert places.covers(LINE + 50.0)
    assert not places.covers(LINE)


def test_places_move_with_the_map_frame():
    places, motion = GivenUp(), Pose2D(3.0, -2.0, 0.6)
    places.add(LINE)
    moved = moved_points(motion, LINE)
    expected = [motion @ Pose2D(x, y, 0.0) for x, y in LINE.tolist()]
    np.testing.assert_allclose(moved, [pose[:2] for pose in expected])
    assert places.moved(motion).covers(moved)
    assert not places.moved(motion).covers(LINE)
    assert GivenUp().moved(motion).tiles == []
