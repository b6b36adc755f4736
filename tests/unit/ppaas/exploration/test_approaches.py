"""Approaches: where the robot sees a frontier from, and how far that is."""

import math

import numpy as np
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.errors import StartOccupied, StartOutsideMap
from ppaas.exploration.approaches import SIGHT, Approach, Reach
from ppaas.exploration.frontiers import find_frontiers
from ppaas.geometry import Pose2D
from ppaas.maps.grid import UNKNOWN, GridInfo, GridMap

ROBOT = Pose2D(1.0, 1.5)


def room() -> np.ndarray:
    """Return a room of 3 x 3 m, cells of 0.05 m, with walls around it."""
    cells = np.zeros((60, 60), np.int8)
    cells[0], cells[-1], cells[:, 0], cells[:, -1] = 100, 100, 100, 100
    return cells


def approaches(cells: np.ndarray, robot: Pose2D = ROBOT) -> list[Approach]:
    grid = GridMap(cells, GridInfo(0.05, cells.shape[1], cells.shape[0]))
    return Reach(grid, build_layers(grid).costmap, robot).approaches(find_frontiers(grid, 0.2))


def test_pose_is_on_the_frontier_in_its_middle_and_faces_the_unknown():
    cells = room()
    cells[1:-1, 40:-1] = UNKNOWN
    (approach,) = approaches(cells)
    assert approach.pose.x == pytest.approx(1.975)
    assert approach.pose.y == pytest.approx(1.5, abs=0.06)
    assert approach.pose.theta == pytest.approx(0.0)
    assert approach.distance == pytest.approx(approach.pose.distance_to(ROBOT), rel=0.1)


def test_frontier_behind_a_wall_has_no_approach():
    cells = room()
    cells[:, 38:40] = 100
    cells[20:30, 50:58] = UNKNOWN
    assert approaches(cells) == []


def test_frontier_that_is_too_near_a_wall_is_seen_from_beside_it():
    cells = room()
    cells[1:3, 30:40] = UNKNOWN  # a strip along the wall, which the robot cannot enter
    cells[1:3, 20:30] = 100
    cells[1:3, 40:50] = 100
    (approach,) = approaches(cells)
    assert 0.0 < math.dist(approach.pose[:2], approach.seen) <= SIGHT
    assert approach.pose.y > approach.seen[1]


def test_frontier_that_no_cell_sees_has_no_approach():
    cells = room()
    cells[:6, :] = 100
    cells[2:4, 20:40] = 0  # a slot inside the wall
    cells[2:4, 28:32] = UNKNOWN
    assert approaches(cells) == []


def test_robot_too_near_a_wall_drives_to_the_next_free_cell_first():
    cells = room()
    cells[1:-1, 40:-1] = UNKNOWN
    assert len(approaches(cells, Pose2D(0.1, 1.5))) == 1


def test_robot_outside_the_map_is_refused():
    with pytest.raises(StartOutsideMap, match="outside the map"):
        approaches(room(), Pose2D(9.0, 1.0))


def test_robot_without_free_space_around_is_refused():
    with pytest.raises(StartOccupied, match="drive it to a free place"):
        approaches(np.full((100, 100), UNKNOWN, np.int8), Pose2D(2.5, 2.5))
