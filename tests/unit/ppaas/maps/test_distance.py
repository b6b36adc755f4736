"""The exact Euclidean distance transform."""

import numpy as np
import pytest
from hypothesis import given
from scipy import ndimage

from ppaas.maps.free_space import distance_to_occupied
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.maps.kernels import distance as kernels
from tests.reference.maps import maps as twin
from tests.support.world.maps import grid_of, occupied_arrays, real_map


@given(occupied_arrays(20))
def test_distance_agrees_with_the_twin(occupied):
    distance = distance_to_occupied(grid_of(occupied, 0.05))
    assert distance.dtype == np.float32
    np.testing.assert_allclose(distance, twin.distance(occupied, 0.05), rtol=1e-6)


@given(occupied_arrays(20))
def test_serial_and_parallel_distances_are_equal(occupied):
    assert np.array_equal(kernels.distance_serial(occupied, 0.1), kernels.distance_parallel(occupied, 0.1))


@pytest.mark.parametrize("shape", [(300, 170), (1, 400), (400, 1), (64, 128), (65, 129)])
@pytest.mark.parametrize("share", [0.3, 0.001])
def test_distance_agrees_with_scipy(shape, share):
    occupied = np.random.default_rng(1).random(shape) < share
    occupied[shape[0] // 2, shape[1] // 3] = True
    expected = ndimage.distance_transform_edt(~occupied) * 0.05
    np.testing.assert_allclose(distance_to_occupied(grid_of(occupied, 0.05)), expected, rtol=1e-6)


def test_distance_without_obstacles_exceeds_any_in_the_map():
    distance = distance_to_occupied(grid_of(np.zeros((30, 40), np.uint8), 0.5))
    assert (distance == 35.0).all()


def test_65_is_occupied_and_unknown_is_not():
    grid = GridMap(np.array([[65, 64, -1]], np.int8), GridInfo(1.0, 3, 1))
    assert distance_to_occupied(grid).tolist() == [[0.0, 1.0, 2.0]]


def test_read_only_map_is_accepted():
    grid = grid_of(np.eye(5, dtype=np.uint8))
    grid.data.flags.writeable = False
    assert distance_to_occupied(grid)[0, 4] == pytest.approx(np.hypot(2, 2))


def test_distances_of_a_real_map_agree_with_scipy(data):
    grid = real_map(data, "warehouse")
    expected = ndimage.distance_transform_edt(grid.data < 65) * grid.info.resolution
    np.testing.assert_allclose(distance_to_occupied(grid), expected, rtol=1e-6)


def test_warm_calls_every_kernel():
    kernels.warm()
    assert kernels.distance_serial.nopython_signatures
    assert kernels.distance_parallel.nopython_signatures
