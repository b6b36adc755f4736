import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.maps.octree import OcTree, octree_of
from ppaas.maps.voxels import FREE, MAX_VOXELS, OCCUPIED, UNKNOWN, Point3D, VoxelGrid, VoxelInfo
from tests.support.world import voxels

KINDS = st.sampled_from([FREE, OCCUPIED, UNKNOWN])
UNIFORM = st.builds(lambda shape, value: np.full(shape, value, np.uint8), st.tuples(*[st.integers(1, 9)] * 3), KINDS)
ARRAYS = st.one_of(voxels.grid_arrays(), UNIFORM, hnp.arrays(np.uint8, (4, 4, 4), elements=KINDS, fill=KINDS))
ORIGINS = st.tuples(*[st.integers(-12, 12)] * 3)


def known_part(data):
    """Return the array cropped to its known voxels, and the index of the first one."""
    known = np.argwhere(data != UNKNOWN)
    first, last = known.min(axis=0), known.max(axis=0) + 1
    return data[tuple(map(slice, first, last))], first


@given(ARRAYS, ORIGINS)
def test_grid_round_trips_as_octree(data, origin):
    data[0, 0, 0] = OCCUPIED
    edge = 0.05
    grid = voxels.grid(data, edge, Point3D(*(edge * at for at in origin)))
    again = octree_of(grid).voxels()
    expected, first = known_part(data)
    assert np.array_equal(again.data, expected)
    np.testing.assert_allclose(again.info.origin, (np.array(origin) + first[::-1]) * edge, atol=1e-9)


@given(ARRAYS, ORIGINS)
def test_eight_equal_siblings_are_merged(data, origin):
    tree = octree_of(voxels.grid(data, 1.0, Point3D(*map(float, origin))))
    edges = 1 << (16 - tree.depths.astype(int))
    parents = {}
    for corner, edge, occupied in zip(tree.corners.tolist(), edges.tolist(), tree.occupied.tolist(), strict=True):
        key = (*(at // (2 * edge) for at in corner), edge, occupied)
        parents[key] = parents.get(key, 0) + 1
    assert max(parents.values(), default=0) < 8


@given(ARRAYS, ORIGINS, st.integers(13, 16))
def test_coarse_voxel_is_occupied_if_any_part_is_free_if_all_are(data, origin, depth):
    data[0, 0, 0] = OCCUPIED
    size = 1 << (16 - depth)
    coarse = octree_of(voxels.grid(data, 1.0, Point3D(*map(float, origin)))).voxels(depth)
    assert coarse.info.resolution == size
    around = np.full([side + 64 for side in data.shape], UNKNOWN, np.uint8)
    around[tuple(slice(32, 32 + side) for side in data.shape)] = data
    for voxel in np.ndindex(coarse.data.shape):
        corner = np.array(coarse.info.origin)[::-1] + np.array(voxel) * size - origin[::-1] + 32
        part = around[tuple(slice(int(at), int(at) + size) for at in corner)]
        expected = OCCUPIED if (part == OCCUPIED).any() else FREE if (part == FREE).all() else UNKNOWN
        assert coarse.data[voxel] == expected


def test_voxels_can_be_cropped_from_a_very_large_tree():
    corners = np.array([[0, 0, 0], [32768, 32768, 32768], [32769, 32768, 32768]], np.uint16)
    tree = OcTree(0.1, corners, np.array([4, 16, 16], np.uint8), np.array([False, True, False]))
    with pytest.raises(InvalidMap, match="coarser depth"):
        tree.voxels()
    near = tree.voxels(low=(-0.05, 0, 0), high=(0.15, 0.1, 0.1))
    assert near.data.tolist() == [[[UNKNOWN, OCCUPIED, FREE]]]
    assert tree.voxels(low=(-9e9, -9e9, -9e9), high=(-3276.7, -3276.75, -3276.75)).data.tolist() == [[[0]]]
    assert tree.voxels(4).info.resolution == pytest.approx(409.6)


@pytest.mark.parametrize(
    "wrong", [{"depth": 0}, {"depth": 17}, {"low": (9, 9, 9)}, {"low": (0, 0)}, {"high": [np.nan] * 3}]
)
def test_invalid_depths_and_corners_are_refused(wrong):
    with pytest.raises(InvalidInput):
        octree_of(voxels.room()).voxels(**wrong)


def test_an_empty_tree_has_no_nodes_and_no_voxels():
    tree = octree_of(voxels.grid(np.full((2, 2, 2), UNKNOWN, np.uint8)))
    assert (tree.nodes, tree.at_depth(9).nodes) == (0, 0)
    with pytest.raises(InvalidMap, match="empty"):
        tree.voxels()


@pytest.mark.parametrize("origin", [(0.05, 0.0, 0.0), (0.0, 0.0, 3276.8), (-3276.9, 0.0, 0.0)])
def test_a_grid_that_does_not_fit_an_octree_is_refused(origin):
    with pytest.raises(InvalidMap, match="move"):
        octree_of(voxels.grid(np.zeros((1, 1, 1), np.uint8), 0.1, Point3D(*origin)))


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
