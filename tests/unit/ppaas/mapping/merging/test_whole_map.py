import math

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.mapping.merging.matches import WholeMap
from ppaas.mapping.merging.parameters import MergeParameters
from tests.support.budget import examples
from tests.support.world.room_scans import ALL_ROUND, ROOM, ranges_at

ANGLES = ALL_ROUND.angle_min + ALL_ROUND.angle_increment * np.arange(ALL_ROUND.beams)


def points_at(pose):
    """Return the points (n, 2) that a laser sees at a pose in the room, in its own frame."""
    ranges = ranges_at(pose, ALL_ROUND, ROOM).astype(np.float64)
    return np.column_stack((np.cos(ANGLES), np.sin(ANGLES))) * ranges[:, None]


def map_of_the_room():
    centre = points_at((2.0, -1.0, 0.0)) + np.array((2.0, -1.0))
    corner = points_at((-3.0, 2.5, 0.0)) + np.array((-3.0, 2.5))
    return WholeMap(np.concatenate((centre, corner)), np.array([(2.0, -1.0, 0.0), (-3.0, 2.5, 0.0)]), MergeParameters())


MAP = map_of_the_room()


@settings(max_examples=examples(20))
@example(2.0, -1.59375, 1.5)
@given(x=st.floats(0.5, 3.0), y=st.floats(-2.0, 0.5), theta=st.floats(-math.pi, math.pi))
def test_a_place_is_found_at_any_heading(x, y, theta):
    (best, score), *_ = MAP.places(points_at((x, y, theta)))
    assert best.distance_to(Pose2D(x, y)) < 0.15
    assert abs((best.theta - theta + math.pi) % (2.0 * math.pi) - math.pi) < 0.04
    assert score > 0.6


def test_points_of_another_room_have_no_place():
    scattered = np.random.default_rng(0).uniform(-8.0, 8.0, (300, 2))
    assert MAP.places(scattered) == []
    assert MAP.places(np.empty((0, 2))) == []


def test_two_places_that_look_alike_are_both_found():
    box = np.concatenate([np.column_stack((np.linspace(-1.0, 1.0, 40), np.full(40, y))) for y in (-1.0, 1.0)])
    there = np.concatenate((box, box + np.array((12.0, 0.0))))
    places = WholeMap(there, np.array([(0.0, 0.0, 0.0), (12.0, 0.0, 0.0)]), MergeParameters()).places(box)
    assert sorted(round(place.x) for place, _ in places) == [0, 12]
