"""Questions about the map of a robot that follows."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.maps.grid import UNKNOWN, GridInfo, GridMap
from ppaas.people.following.places import (
    FAILED_RADIUS,
    GROUP_MARGIN,
    LEAST,
    Places,
    StandingRequest,
    choose_place,
    facing,
)
from ppaas.people.talking_groups import distances_to
from tests.support.world.planar_world import walled_map

GRID = walled_map(4, 3, [(2.0, 0.0, 2.2, 2.0)])
TURNED = GridMap(GRID.data, GridInfo(0.05, 80, 60, Pose2D(10.0, -5.0, math.pi / 2)))


def test_robot_stands_on_free_cells_away_from_walls():
    places = Places(build_layers(GRID))
    assert places.standable([(1.0, 1.0), (1.85, 1.0), (2.1, 1.0), (9.0, 1.0)]).tolist() == [True, False, False, False]


@pytest.mark.parametrize(("grid", "frame"), [(GRID, Pose2D(0.0, 0.0)), (TURNED, TURNED.info.origin)])
def test_sight_ends_at_walls_in_maps_of_any_frame(grid, frame):
    places = Places(build_layers(grid))
    origin = frame @ Pose2D(1.0, 1.0)
    assert places.sight(origin, [0.0, math.pi / 2], 5.0).tolist() == pytest.approx([1.0, 1.9], abs=0.01)
    one, other = (tuple((frame @ Pose2D(x, 1.0))[:2]) for x in (1.0, 3.0))
    assert not places.sees(one, other)
    above = tuple((frame @ Pose2D(1.0, 2.5))[:2])
    assert places.sees(one, above)


def test_sight_is_not_limited_outside_the_map():
    assert Places(build_layers(GRID)).sight(Pose2D(50.0, 50.0), [0.0], 3.0).tolist() == [3.0]


def test_people_walk_in_known_cells_without_obstacles():
    grid = GridMap(GRID.data.copy(), GRID.info)
    grid.data[:20, :20] = UNKNOWN
    found = Places(build_layers(grid)).walkable(1.0, 1.0, 5.0, 0.25)
    assert found is not None
    free, info = found
    assert info.resolution == pytest.approx(0.25)
    inside = {xy: bool(free[info.cell_of(*xy)]) for xy in [(1.5, 1.5), (0.5, 0.5), (2.1, 1.0), (3.0, 1.0)]}
    assert list(inside.values()) == [True, False, False, True]
    assert np.isclose(info.to_world((0, 0)), 0.125).all()
    assert Places(build_layers(grid)).walkable(50.0, 50.0, 2.0, 0.25) is None


WALL = (5.0, 0.0, 5.2, 4.0)
HALL = Places(build_layers(walled_map(8, 6, [WALL])))
PERSON, ROBOT = (3.0, 3.0), Pose2D(1.0, 3.0)


def chosen(**request):
    return choose_place(
        StandingRequest(**{"person": PERSON, "robot": ROBOT, "distance": 1.2, "wanted": math.pi} | request), HALL
    )


def test_place_is_on_the_wanted_side_at_the_distance():
    assert chosen() == pytest.approx((1.8, 3.0))
    assert chosen(wanted=math.pi / 2) == pytest.approx((3.0, 4.2))


def test_place_on_the_path_walked_is_taken_if_it_is_free():
    assert chosen(path=(2.5, 4.0)) == (2.5, 4.0)
    assert chosen(path=(0.05, 3.0)) == pytest.approx((1.8, 3.0))


def test_place_is_not_behind_a_wall_nor_near_one():
    place = chosen(person=(4.5, 2.0), wanted=0.0)
    assert place is not None and place[0] < 5.0
    assert HALL.standable([place]).all() and HALL.sees(place, (4.5, 2.0))


def test_nobody_stands_in_the_way_of_other_people_and_robots():
    other = np.array([[1.8, 3.2]])
    assert math.dist(chosen(people=other), other[0]) >= 0.8
    assert math.dist(chosen(robots=other), other[0]) >= 0.6
    assert math.dist(chosen(failed=other), other[0]) >= FAILED_RADIUS


def test_place_is_outside_of_the_space_between_two_who_talk():
    talking = np.array([PERSON, [1.0, 3.0]])
    place = chosen(groups=[talking], people=talking[1:])
    assert distances_to(np.array([place]), [talking])[0] >= GROUP_MARGIN


def test_place_of_before_is_kept_while_it_is_about_as_good():
    assert chosen(wanted=math.pi - 0.1, last=math.pi - 0.1 + math.tau / 24) != chosen(wanted=math.pi + 1.0)


def test_no_place_is_found_if_all_are_taken():
    crowd = np.array([(3.0 + x, 3.0 + y) for x in range(-2, 3) for y in range(-2, 3)], dtype=float)
    assert chosen(people=crowd) is None
    assert chosen(person=(20.0, 20.0)) is None


@given(st.floats(0.5, 7.5), st.floats(0.5, 5.5), st.floats(-math.pi, math.pi), st.floats(0.6, 3.0))
def test_every_place_is_free_and_sees_the_person(x, y, wanted, distance):
    assume(not (WALL[0] <= x <= WALL[2] and y <= WALL[3]))  # nobody is in a wall, or on its edge
    place = chosen(person=(x, y), wanted=wanted, distance=distance)
    if place is not None:
        assert HALL.standable([place]).all()
        assert HALL.sees((x, y), place)
        assert LEAST - 1e-9 <= math.dist(place, (x, y)) <= 1.35 * distance + 1e-9


def test_robot_faces_the_person():
    assert facing((1.0, 1.0), (1.0, 2.0)) == pytest.approx((1.0, 1.0, math.pi / 2))
