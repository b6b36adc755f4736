import numpy as np
import pytest

from ppaas.errors import InvalidMap
from ppaas.geometry import Pose2D
from ppaas.imports.maps.clouds.pcd import read_pcd
from ppaas.imports.maps.clouds.ply import read_ply
from ppaas.imports.maps.clouds.xyz import read_xyz
from ppaas.imports.report import ImportReport
from ppaas.maps.exports.point_files import pcd_file, ply_file, points_of_grid, points_of_octree, xyz_file
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.maps.octree import octree_of
from ppaas.maps.voxels import OCCUPIED, UNKNOWN, Point3D, VoxelGrid, VoxelInfo


def test_all_occupied_voxels_of_an_octree_are_points_also_those_of_merged_leaves():
    data = np.full((4, 6, 8), UNKNOWN, np.uint8)
    data[:2, :2, :2] = data[2:, 2:4, 4:6] = data[3, 5, 7] = OCCUPIED
    data[1, 4, 4] = 0
    grid = VoxelGrid(data, VoxelInfo(0.5, 8, 6, 4, Point3D(-2.0, 1.0, 0.0)))
    tree = octree_of(grid)
    assert (tree.depths < 16).any()
    expected = grid.info.to_world(np.argwhere(data == OCCUPIED))
    assert sorted(points_of_octree(tree).tolist()) == sorted(expected.tolist())


def test_walls_of_a_grid_are_points_on_the_floor():
    grid = GridMap(np.array([[0, 100], [-1, 70]], np.int8), GridInfo(1.0, 2, 2, Pose2D(10.0, 20.0, np.pi / 2)))
    assert np.allclose(points_of_grid(grid), [[9.5, 21.5, 0.0], [8.5, 21.5, 0.0]])
    with pytest.raises(InvalidMap, match="0 occupied points"):
        points_of_grid(GridMap(np.zeros((2, 2), np.int8), grid.info))


@pytest.mark.parametrize(("write", "read"), [(pcd_file, read_pcd), (ply_file, read_ply), (xyz_file, read_xyz)])
def test_files_are_read_again(write, read):
    points = np.random.default_rng(2).normal(0.0, 50.0, (300, 3)).astype(np.float32)
    assert np.allclose(read(write(points), ImportReport("a")).points, points, atol=1e-4)
