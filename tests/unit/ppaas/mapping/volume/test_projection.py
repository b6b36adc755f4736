"""Projected maps against a twin, heights, and speckles."""

import msgspec
import numpy as np
import pytest

from ppaas.errors import InvalidMap
from ppaas.mapping.volume.exports import project_volume
from ppaas.mapping.volume.parameters import VolumeParameters
from ppaas.mapping.volume.voxel_volume import VoxelVolume
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN
from tests.reference.mapping.volume import MIDDLE, projected
from tests.unit.ppaas.mapping.volume.test_voxel_volume import cloud, log_odds


def volume_of(**parameters):
    volume = VoxelVolume(msgspec.structs.replace(VolumeParameters(resolution=0.1), **parameters))
    for seed in range(3):
        volume.insert(*cloud(seed, 60, 1.0))
    return volume


@pytest.mark.parametrize("heights", [(-100.0, 100.0), (-0.3, 0.25), (0.1, 0.2), (5.0, 6.0)])
def test_map_is_that_of_the_twin(heights):
    volume = volume_of(occupancy_min_z=heights[0], occupancy_max_z=heights[1])
    result = project_volume(volume)
    cells = projected(log_odds(volume), *heights, 0.1)
    corner = np.rint(np.array([result.info.origin.x, result.info.origin.y]) / 0.1).astype(int) + MIDDLE
    rows, columns = np.nonzero(result.data != UNKNOWN)
    found = zip((columns + corner[0]).tolist(), (rows + corner[1]).tolist(), result.data[rows, columns], strict=True)
    assert {(x, y): value for x, y, value in found} == cells


def test_speckles_are_left_out_if_wanted():
    points = np.array([[1.05, 0.05, 0.05], [1.05, 2.35, 0.05], [1.05, 2.45, 0.15]], np.float32)
    for wanted, value in ((False, OCCUPIED), (True, UNKNOWN)):
        volume = VoxelVolume(VolumeParameters(resolution=0.1, filter_speckles=wanted))
        volume.insert(points, [0.05, 0.05, 0.05])
        result = project_volume(volume)
        cells = result.info.to_cells(points[:, :2].astype(float))
        assert result.data[tuple(cells.T)].tolist() == [value, OCCUPIED, OCCUPIED]
        assert result.data[tuple(result.info.to_cells([[0.55, 0.05]]).T)].tolist() == [FREE]


def test_an_empty_volume_has_no_map():
    with pytest.raises(InvalidMap):
        project_volume(VoxelVolume(VolumeParameters()))
