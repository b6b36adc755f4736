"""Search for a person who vanished."""

import math

import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.messages.people_coordination import SensorView
from ppaas.people.following.places import Places
from ppaas.people.following.search import FASTEST, SearchArea
from tests.support.world.planar_world import walled_map

ROOMS = Places(build_layers(walled_map(12, 8, [(0, 3.9, 4, 4.1), (5, 3.9, 12, 4.1)])))
"""Two rooms, with a door at x = 4 to 5 m."""

ALL_AROUND = [SensorView(0.0, 0.0, 0.0, 2.0 * math.pi, 0.0, 6.0)]
AHEAD = [SensorView(0.1, 0.0, 0.0, 1.0, 0.0, 5.0)]
BELOW = Pose2D(2.0, 2.0, 0.0)


def search(last=(4.5, 4.5), velocity=(0.0, 0.5)) -> SearchArea:
    return SearchArea(ROOMS, last, velocity, 0.0)


def test_area_begins_around_the_last_position_and_grows_at_walking_speed():
    found = search()
    assert found.may_be_at(4.5, 4.6) and not found.may_be_at(4.5, 6.5)
    before = found.area
    found.update(3.0, BELOW, [])
    assert found.area > before
    assert found.may_be_at(4.5, 6.0) and not found.may_be_at(4.5, 4.5 + 3.0 * FASTEST + 1.0)


def test_area_does_not_grow_through_walls():
    found = search(last=(8.0, 4.6))
    found.update(2.0, BELOW, [])
    assert found.may_be_at(8.0, 5.5) and not found.may_be_at(8.0, 3.4)


def test_what_the_robot_sees_to_be_empty_leaves_the_area():
    found = search(last=(2.0, 3.0))
    found.update(0.1, BELOW, ALL_AROUND)
    assert found.area == 0.0 and found.next_place(BELOW, ALL_AROUND) is None


def test_robot_goes_to_the_place_of_the_last_sight_first():
    place = search().next_place(BELOW, ALL_AROUND)
    assert place is not None and math.dist(place[:2], (4.5, 4.5)) < 1.0


def test_robot_looks_at_a_place_in_sight_by_turning():
    found = search(last=(2.0, 3.2))
    found.update(0.1, BELOW, AHEAD)
    place = found.next_place(BELOW, AHEAD)
    assert place is not None and place[:2] == BELOW[:2]
    assert place.theta == pytest.approx(math.pi / 2, abs=0.5)
    found.update(0.2, place, AHEAD)
    assert not found.may_be_at(2.0, 3.2)


def test_robot_prefers_the_direction_in_which_the_person_walked():
    places = [search((4.5, 4.5), (side, 0.3)) for side in (0.6, -0.6)]
    robot = Pose2D(4.5, 3.0, math.pi / 2)
    goals = []
    for found in places:
        for second in range(1, 8):
            found.update(float(second), robot, AHEAD)
        goals.append(found.next_place(robot, AHEAD))
    assert goals[0].x > 4.5 > goals[1].x


def test_place_that_is_not_reached_is_not_looked_at_again():
    found = search()
    first = found.next_place(BELOW, AHEAD)
    found.skip()
    second = found.next_place(BELOW, AHEAD)
    assert first is not None and (second is None or second != first)


def test_search_outside_the_map_finds_nothing():
    assert search(last=(100.0, 100.0)).next_place(BELOW, AHEAD) is None
