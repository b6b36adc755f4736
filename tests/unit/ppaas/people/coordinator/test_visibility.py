"""Visibility: views, walls, and people who hide others."""

import math

import numpy as np
import pytest

from ppaas.costmap.costmap import FREE_SPACE, LETHAL_OBSTACLE, NO_INFORMATION, Costmap
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.messages.people_coordination import SensorView
from ppaas.people.coordinator.visibility import MapArea, Walls, hidden_by_people, in_views, view_of, visible_pairs

NOBODY = np.zeros((0, 2))
CAMERA = SensorView(0.1, 0.0, 0.0, 1.0, 0.4, 5.0)


def walls(origin: Pose2D = Pose2D(0.0, 0.0)) -> Walls:
    """Return a wall at x from 3.0 to 3.05 m, from y = 0 to 2 m, on a map of 6 m × 4 m."""
    data = np.zeros((80, 120), np.uint8)
    data[:40, 60] = LETHAL_OBSTACLE
    return Walls(Costmap(data, GridInfo(0.05, 120, 80, origin)))


@pytest.mark.parametrize(
    ("point", "seen"), [((2.0, 1.0), True), ((5.0, 1.0), False), ((5.0, 3.9), True), ((3.1, 1.0), True)]
)
def test_a_wall_hides_who_is_behind_it_but_not_who_is_beside(point: tuple[float, float], seen: bool) -> None:
    assert walls().free_between(np.array([1.0, 1.0]), np.array([point])).tolist() == [seen]


def test_a_map_may_be_turned_and_people_may_be_outside() -> None:
    turned = walls(Pose2D(10.0, 0.0, math.pi / 2))
    points = np.array([[9.0, 5.0], [6.5, 5.5], [-40.0, 2.0]])
    assert turned.free_between(np.array([9.0, 1.0]), points).tolist() == [False, True, True]


def test_a_camera_sees_ahead_within_its_angle_and_range() -> None:
    view = view_of(0, Pose2D(1.0, 1.0, math.pi / 2), CAMERA)
    people = np.array([[1.0, 3.0], [1.0, -1.0], [1.0, 6.5], [3.0, 2.0], [1.0, 1.3]])
    assert in_views([view], people).tolist() == [[True, False, False, False, False]]


def test_a_person_hides_another_on_the_same_line_and_not_beside_it() -> None:
    origins, points = np.zeros((3, 2)), np.array([[4.0, 0.0], [4.0, 2.0], [1.5, 0.0]])
    assert hidden_by_people(origins, points, np.array([[2.0, 0.1]]), 0.25).tolist() == [True, False, False]


def test_pairs_are_of_robots_that_should_see_a_person() -> None:
    views = [view_of(0, Pose2D(1.0, 1.0), CAMERA), view_of(1, Pose2D(5.5, 1.0, math.pi), CAMERA)]
    people = np.array([[2.0, 1.0], [4.5, 1.0]])
    assert visible_pairs(views, walls(), people, [0, 1], people, radius=0.25) == [(0, 0), (1, 1)]
    assert visible_pairs([], walls(), people, [0, 1], NOBODY, radius=0.25) == []


def test_the_distance_is_that_from_known_free_cells_also_outside_the_map() -> None:
    data = np.full((20, 30), NO_INFORMATION, np.uint8)
    data[5:15, 5:15] = FREE_SPACE
    data[5:15, 14] = LETHAL_OBSTACLE
    area = MapArea(Costmap(data, GridInfo(0.1, 30, 20, Pose2D(1.0, 2.0))))
    points = np.array([[1.95, 3.05], [2.85, 3.05], [6.0, 3.05], [1.95, 0.0]])
    # In it; 5 cells behind the wall; beyond the right edge; below the lower edge.
    assert area.distance(points) == pytest.approx([0.0, 0.5, 3.7, 2.5], abs=0.11)


def test_a_map_without_free_cells_has_nobody() -> None:
    area = MapArea(Costmap(np.full((4, 5), NO_INFORMATION, np.uint8), GridInfo(0.1, 5, 4)))
    assert area.distance(np.array([[0.2, 0.2]]))[0] > 0.5
