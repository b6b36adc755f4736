import math

import numpy as np
import pytest

from ppaas.errors import InvalidMap
from ppaas.maps.voxels import MAX_VOXELS, Point3D, VoxelGrid, VoxelInfo


def test_a_point_lies_in_the_voxel_around_it():
    info = VoxelInfo(0.5, 4, 3, 2, Point3D(-1.0, 2.0, 0.5))
    assert info.shape == (2, 3, 4)
    assert info.to_voxels((-0.9, 3.4, 1.2)).tolist() == [1, 2, 0]
    assert info.to_world((1, 2, 0)).tolist() == [-0.75, 3.25, 1.25]
    every = np.argwhere(np.ones(info.shape, bool))
    assert np.array_equal(info.to_voxels(info.to_world(every)), every)


@pytest.mark.parametrize(
    ("resolution", "size", "origin"),
    [
        (0.0, (1, 1, 1), (0, 0, 0)),
        (math.nan, (1, 1, 1), (0, 0, 0)),
        (0.1, (0, 1, 1), (0, 0, 0)),
        (0.1, (-1, -1, 1), (0, 0, 0)),
        (0.1, (1, 1, 1), (0, math.inf, 0)),
    ],
)
def test_an_invalid_grid_is_refused(resolution, size, origin):
    with pytest.raises(InvalidMap):
        VoxelInfo(resolution, *size, Point3D(*origin))


def test_too_large_grid_is_refused_with_advice():
    VoxelInfo(0.1, MAX_VOXELS, 1, 1)
    with pytest.raises(InvalidMap, match="crop the map, or read it at a coarser depth"):
        VoxelInfo(0.1, MAX_VOXELS // 2, 1, 3)


@pytest.mark.parametrize(
    "data", [np.zeros((1, 1, 2), np.uint8), np.zeros((1, 1, 1), np.int8), np.ones((1, 1, 1), np.uint8)]
)
def test_voxels_of_another_shape_type_or_value_are_refused(data):
    with pytest.raises(InvalidMap):
        VoxelGrid(data, VoxelInfo(0.1, 1, 1, 1))
