"""Octrees and OctoMap files of voxel volumes against a twin of OctoMap's writer."""

import numpy as np
import pytest

from ppaas.mapping.volume.exports import binary_file, full_file, octree_of_volume
from ppaas.mapping.volume.parameters import VolumeParameters
from ppaas.mapping.volume.voxel_volume import VoxelVolume
from ppaas.maps.octomap import parse_octomap
from tests.reference.mapping.volume import octree_body
from tests.unit.ppaas.mapping.volume.test_voxel_volume import cloud, log_odds

HEAD = (
    "# Octomap OcTree {}file\n# (feel free to add / change comments, but leave the first line as it is!)\n#\n"
    "id OcTree\nsize {}\nres 0.1\ndata\n"
)


@pytest.fixture(scope="module", params=["walls", "inside"])
def volume(request):
    """A volume of a few clouds; in the second one, whole blocks are free and clamped."""
    result = VoxelVolume(VolumeParameters(resolution=0.1))
    if request.param == "inside":
        ticks = (np.arange(-13, 13) + 0.5) * 0.1
        points = np.stack(np.meshgrid(ticks, ticks, ticks), axis=-1).reshape(-1, 3).astype(np.float32)
        shell = points[np.abs(points).max(axis=1) > 1.2] * np.float32(1.5)
        for _ in range(8):
            result.insert(shell, [0.0, 0.0, 0.0])
    for seed in range(3):
        result.insert(*cloud(seed, 40, 1.0))
    return result


def test_binary_file_is_that_of_octomap(volume):
    body, nodes = octree_body(log_odds(volume), "bt")
    assert binary_file(volume) == HEAD.format("binary ", nodes).encode() + body


def test_full_file_is_that_of_octomap(volume):
    body, nodes = octree_body(log_odds(volume), "ot")
    assert full_file(volume) == HEAD.format("", nodes).encode() + body


def test_files_are_read_as_the_octree_of_the_volume(volume):
    tree = octree_of_volume(volume)
    for text in (binary_file(volume), full_file(volume)):
        read = parse_octomap(text)
        assert read.resolution == tree.resolution
        assert np.array_equal(read.voxels().data, tree.voxels().data)


def test_equal_siblings_are_merged(volume):
    assert len(octree_of_volume(volume).depths) < len(log_odds(volume))


def test_an_empty_volume_is_an_empty_file():
    empty = VoxelVolume(VolumeParameters(resolution=0.1))
    assert binary_file(empty) == HEAD.format("binary ", 0).encode()
    assert full_file(empty) == HEAD.format("", 0).encode()
    assert octree_of_volume(empty).nodes == 0
