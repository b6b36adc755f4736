"""Routes: few corners, near to the path."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.wire.vda5050.master.route import MAX_CORNERS, TOLERANCE, Route, nearest_edge, route_of

PLACES = st.lists(st.tuples(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0)), min_size=1, max_size=60)


def poses(places, theta=0.0):
    return [Pose2D(x, y, theta) for x, y in places]


@given(PLACES)
def test_the_path_is_near_to_its_route_and_the_ends_are_the_same(places):
    route = route_of(poses(places))
    assert tuple(route.points[0]) == places[0]
    assert tuple(route.points[-1]) == places[-1]
    assert all(nearest_edge(route.points, x, y)[1] <= TOLERANCE + 1e-9 for x, y in places)


def test_a_straight_line_has_two_corners():
    assert len(route_of(poses([(0.1 * index, 0.0) for index in range(200)])).points) == 2


def test_a_path_with_too_many_corners_is_simplified_further():
    spiral = [(0.001 * index * math.cos(index), 0.001 * index * math.sin(index)) for index in range(20000)]
    assert len(route_of(poses(spiral)).points) <= MAX_CORNERS


@pytest.mark.parametrize("bad", [[], [Pose2D(math.nan, 0.0)], [Pose2D(0.0, math.inf)]])
def test_a_path_that_is_none_is_refused(bad):
    with pytest.raises(InvalidInput):
        route_of(bad)


def test_the_rest_of_a_route_begins_where_the_agv_is():
    route = Route(np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 4.0)]), 1.0)
    rest = route.after(3.0, 0.2, near=0.5)
    assert rest is not None
    assert rest.points.tolist() == [[3.0, 0.2], [4.0, 0.0], [4.0, 4.0]]
    assert route.after(2.0, 2.0, near=0.5) is None
    at_corner = route.after(4.0, 0.0, near=0.5)
    assert at_corner is not None
    assert at_corner.points.tolist() == [[4.0, 0.0], [4.0, 4.0]]
    assert route.before(4.0, 1.0).points.tolist() == [[0.0, 0.0], [4.0, 0.0], [4.0, 1.0]]


def test_routes_are_one_if_they_are_near_and_end_alike():
    route = Route(np.array([(0.0, 0.0), (4.0, 0.0)]), 3.1)
    assert route.is_near(Route(np.array([(0.0, 0.1), (2.0, 0.1), (4.0, 0.0)]), -3.1), 0.3)
    assert not route.is_near(Route(np.array([(0.0, 0.1), (2.0, 1.0), (4.0, 0.0)]), 3.1), 0.3)
    assert not route.is_near(Route(np.array([(0.0, 0.0), (4.0, 0.0)]), 0.0), 0.3)
    assert not route.is_near(Route(np.array([(0.0, 0.0), (3.0, 0.0)]), 3.1), 0.3)
