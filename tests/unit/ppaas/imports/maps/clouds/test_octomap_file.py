import numpy as np
import pytest

from ppaas.errors import InvalidMap
from ppaas.geometry import Pose2D
from ppaas.imports.maps.clouds.octomap_file import free_columns, read_octomap
from ppaas.imports.maps.importing import import_map
from ppaas.imports.report import ImportReport
from ppaas.maps.grid import GridInfo
from ppaas.maps.octomap import binary_octomap
from ppaas.maps.octree import octree_of
from ppaas.maps.voxels import FREE, OCCUPIED, UNKNOWN, Point3D, VoxelGrid, VoxelInfo

SHAPE = (8, 24, 32)


def room():
    """Return the voxels of a room: a floor, walls, and free space between, of which a corner is unknown."""
    data = np.full(SHAPE, FREE, np.uint8)
    data[0] = OCCUPIED
    data[:, [0, -1]] = data[:, :, [0, -1]] = OCCUPIED
    data[:, 16:23, 24:31] = UNKNOWN
    return VoxelGrid(data, VoxelInfo(0.25, SHAPE[2], SHAPE[1], SHAPE[0], Point3D(-4.0, -2.0, -1.0)))


def test_a_map_with_an_octomap_alone_gets_a_grid():
    imported, report = import_map(binary_octomap(octree_of(room())), "room.bt")
    grid = imported.grid
    assert grid.info.resolution == 0.25

    def at(x, y):
        return int(grid.data[grid.info.cell_of(x, y)])

    assert (at(0.1, 0.1), at(-3.9, 0.1), at(3.0, 2.9)) == (0, 100, -1)
    assert any(entry.part == "floor" and "-0.88" in entry.text for entry in report.entries)
    assert imported.octomap is not None


def test_free_columns_are_those_of_the_voxels():
    grid = room()
    tree = octree_of(grid)
    assert (tree.depths < 16).any()
    for size, (low, high) in ((0.25, (-0.6, 0.3)), (0.125, (0.3, 0.9)), (0.5, (-0.9, -0.8))):
        info = GridInfo(size, int(8 / size), int(6 / size), Pose2D(-4.0, -2.0, 0.0))
        layers = [k for k in range(SHAPE[0]) if -1.0 + 0.25 * k < high and -1.0 + 0.25 * (k + 1) > low]
        free = (grid.data[layers] == FREE).any(axis=0)
        rows, columns = np.mgrid[: info.height, : info.width]
        middles = info.to_world(np.stack((rows, columns), axis=-1)) - (-4.0, -2.0)
        cells = np.minimum((middles / 0.25 + 1e-9).astype(int), (SHAPE[2] - 1, SHAPE[1] - 1))
        assert np.array_equal(free_columns(tree, info, low, high), free[cells[..., 1], cells[..., 0]])


def test_a_file_without_obstacles_is_refused():
    nothing = VoxelGrid(np.zeros((2, 2, 2), np.uint8), VoxelInfo(0.5, 2, 2, 2))
    with pytest.raises(InvalidMap, match="occupied"):
        read_octomap(binary_octomap(octree_of(nothing)), ImportReport("a.bt"))


def test_a_real_building_is_one_free_space(data):
    imported, _ = import_map((data / "octomap" / "geb079.bt").read_bytes(), "geb079.bt")
    free = (imported.grid.data == 0).sum() * imported.grid.info.resolution**2
    assert free > 100.0
