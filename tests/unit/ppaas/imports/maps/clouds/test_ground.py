import numpy as np
import pytest

from ppaas.imports.maps.clouds.ground import find_floor
from ppaas.imports.maps.common.imported_map import grid_around
from tests.support.world.clouds import FLOOR, hill_points, room_points


def floor_of(points, resolution, ground=None):
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    info = grid_around(low - resolution, high + resolution, resolution)
    return find_floor(points.astype(np.float32), info, ground)


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_the_floor_of_a_room_is_below_its_ceiling(noise):
    points = room_points()
    points[:, 2] += np.random.default_rng(1).normal(0.0, noise, len(points))
    floor = floor_of(points, 0.05)
    assert floor.is_flat
    assert floor.level == pytest.approx(FLOOR, abs=0.02)
    assert np.allclose(floor.heights, points[:, 2] - floor.level, atol=1e-5)


def test_the_lowest_of_two_storeys_is_taken():
    points = np.concatenate((room_points(), room_points() + np.array((0.0, 0.0, 3.0))))
    assert floor_of(points, 0.05).level == pytest.approx(FLOOR, abs=0.02)


def test_a_hole_below_the_floor_is_no_floor():
    pit = room_points()[:200] - np.array((0.0, 0.0, 2.0))
    assert floor_of(np.concatenate((room_points(), pit)), 0.05).level == pytest.approx(FLOOR, abs=0.02)


def test_the_ground_of_a_slope_is_found_below_walls_and_trees():
    points = hill_points()
    true = points[:, 2] - 0.1 * points[:, 0]
    floor = floor_of(points, 0.2)
    assert not floor.is_flat
    inner = (points[:, :2] > 1.0).all(axis=1) & (points[:, 0] < 29.0) & (points[:, 1] < 19.0)
    assert np.abs(floor.heights - true)[inner & (true < 0.01)].max() < 0.12
    assert np.abs(floor.heights - true)[inner].mean() < 0.05


def test_points_that_the_file_calls_ground_decide():
    points = hill_points()
    ground = points[:, 2] - 0.1 * points[:, 0] < 0.01
    floor = floor_of(points, 0.2, ground)
    assert np.abs(floor.heights[ground]).max() < 0.12
