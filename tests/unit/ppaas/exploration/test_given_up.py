"""Places that were given up are recognised although the map has changed a little."""

import numpy as np

from ppaas.exploration import given_up
from ppaas.exploration.given_up import GivenUp
from ppaas.geometry import Pose2D
from ppaas.planar_poses import moved_points

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
