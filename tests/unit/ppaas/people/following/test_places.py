"""Questions about the map of a robot that follows."""

import math

import numpy as np
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.maps.grid import UNKNOWN, GridInfo, GridMap
from ppaas.people.following.places import Places
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
