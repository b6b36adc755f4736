"""Voxel volumes against a twin of OctoMap, and their limits."""

import numpy as np
import pytest

from ppaas.errors import InvalidInput, QuotaExceeded
from ppaas.mapping.volume.parameters import VolumeParameters
from ppaas.mapping.volume.voxel_volume import PARALLEL_FROM, VoxelVolume
from tests.reference.mapping.volume import MIDDLE, OctoMapVolume


def cloud(seed, count, spread=3.0):
    random = np.random.default_rng(seed)
    return (random.normal(size=(count, 3)) * spread).astype(np.float32), random.normal(size=3).astype(np.float32)


def log_odds(volume):
    """Return the known voxels of a volume by key."""
    corners = volume.blocks.corners
    slots, voxels = np.nonzero(~np.isnan(volume.blocks.log_odds))
    keys = corners[slots] + np.stack([voxels % 8, voxels // 8 % 8, voxels // 64], axis=1)
    return dict(zip(map(tuple, keys.tolist()), volume.blocks.log_odds[slots, voxels], strict=True))


def log_odds_at(volume, points):
    """Return the log-odds of the voxels at points, NaN where unknown."""
    known, keys = log_odds(volume), np.floor(np.asarray(points) / volume.parameters.resolution).astype(int) + MIDDLE
    return np.array([known.get(tuple(key), np.nan) for key in keys.tolist()])


def twin_of(parameters):
    return OctoMapVolume(parameters.resolution, parameters.max_range, parameters.model())


@pytest.mark.parametrize("max_range", [-1.0, 2.5])
@pytest.mark.parametrize("resolution", [0.05, 0.3])
def test_log_odds_are_those_of_octomap(resolution, max_range):
    parameters = VolumeParameters(resolution=resolution, max_range=max_range)
    volume, twin = VoxelVolume(parameters), twin_of(parameters)
    for seed in range(5):
        points, origin = cloud(seed, 60)
        volume.insert(points, origin)
        twin.insert(points, origin)
    ours = log_odds(volume)
    different = {key for key in ours.keys() | twin.voxels.keys() if ours.get(key) != twin.voxels.get(key)}
    assert len(different) <= 1e-3 * len(twin.voxels)


def test_rays_through_edges_and_corners_of_voxels_are_those_of_octomap():
    signs = np.stack(np.meshgrid(*[(-1.0, 0.0, 1.0)] * 3), axis=-1).reshape(-1, 3)
    parameters = VolumeParameters(resolution=0.5)
    for point in np.concatenate((signs * 0.5, signs * 2.0)).astype(np.float32) + np.float32(0.25):
        volume, twin = VoxelVolume(parameters), twin_of(parameters)
        for target in (volume, twin):
            target.insert(point[None], np.full(3, 0.25, np.float32))
        assert log_odds(volume) == twin.voxels


def test_log_odds_are_clamped_and_occupied_wins_over_free():
    parameters = VolumeParameters(resolution=0.1)
    volume, model = VoxelVolume(parameters), parameters.model()
    points = np.array([[1.05, 0.05, 0.05], [2.05, 0.05, 0.05]], np.float32)
    for _ in range(20):
        volume.insert(points, [0.05, 0.05, 0.05])
    found = log_odds_at(volume, [[1.05, 0.05, 0.05], [0.55, 0.05, 0.05], [2.05, 0.05, 0.05], [2.25, 0.05, 0.05]])
    assert found[:3].tolist() == [model.most, model.least, model.most]
    assert np.isnan(found[3])


def test_two_threads_give_the_same_as_one():
    points, origin = cloud(1, 2 * PARALLEL_FROM)
    volumes = [VoxelVolume(VolumeParameters(), lambda number=number: number) for number in (1, 2)]
    for volume in volumes:
        for _ in range(2):
            volume.insert(points, origin)
    assert log_odds(volumes[0]) == log_odds(volumes[1])


def test_points_that_are_invalid_too_far_or_outside_the_heights_are_ignored():
    volume = VoxelVolume(VolumeParameters(point_cloud_min_z=-1.0, point_cloud_max_z=1.0))
    points = np.array([[np.nan, 0, 0], [np.inf, 0, 0], [1e30, 0, 0], [2000, 0, 0], [1, 0, 2], [1, 0, -2]], np.float32)
    volume.insert(points, np.zeros(3))
    assert not len(volume.blocks)
    volume.insert(np.empty((0, 3), np.float32), np.zeros(3))
    assert not len(volume.blocks)


def test_first_and_last_voxels_of_the_range_of_keys():
    volume = VoxelVolume(VolumeParameters(resolution=1.0, point_cloud_min_z=-40000.0, point_cloud_max_z=40000.0))
    for side in (-32768.0, 32767.0):
        volume.insert(np.array([[side, side, side]], np.float32), np.clip([side] * 3, -32767.0, 32767.0))
    keys = {key for key, value in log_odds(volume).items() if value > 0}
    assert keys == {(0, 0, 0), (2 * MIDDLE - 1,) * 3}


def test_map_is_unchanged_if_it_would_grow_too_large():
    volume = VoxelVolume(VolumeParameters(max_blocks=4))
    volume.insert(np.array([[0.3, 0.0, 0.0]], np.float32), np.zeros(3))
    before = log_odds(volume)
    with pytest.raises(QuotaExceeded, match="max_blocks allows 4"):
        volume.insert(np.array([[9.0, 0.0, 0.0]], np.float32), np.zeros(3))
    assert log_odds(volume) == before
    volume.insert(np.array([[0.3, 0.0, 0.0]], np.float32), np.zeros(3))
    assert log_odds(volume).keys() == before.keys()


def test_rays_that_are_too_long_are_refused():
    with pytest.raises(QuotaExceeded, match=r"smaller sensor_model\.max_range"):
        VoxelVolume(VolumeParameters(point_cloud_max_z=1e4)).insert(np.full((1, 3), 1500.0, np.float32), np.zeros(3))


@pytest.mark.parametrize(
    ("points", "origin"),
    [
        (np.zeros((2, 3)), np.zeros(3)),
        (np.zeros((2, 2), np.float32), np.zeros(3)),
        (np.zeros((2, 3), np.float32), np.zeros(2)),
        (np.zeros((2, 3), np.float32), [1e9, 0.0, 0.0]),
        (np.zeros((2, 3), np.float32), [np.nan, 0.0, 0.0]),
    ],
)
def test_invalid_clouds_are_refused(points, origin):
    with pytest.raises(InvalidInput):
        VoxelVolume(VolumeParameters()).insert(points, origin)


def test_a_cleared_volume_is_empty():
    volume = VoxelVolume(VolumeParameters())
    volume.insert(*cloud(3, 10))
    volume.clear()
    assert not len(volume.blocks)


@pytest.mark.parametrize("ground", [False, True])
def test_a_voxel_at_the_maximum_range_is_freed_by_rays_that_pass_it(ground):
    """A ray to the ground, whose end shows nothing, leaves it."""
    volume = VoxelVolume(VolumeParameters(resolution=0.05, max_range=2.0))
    origin, far = np.full(3, 0.01, np.float32), np.array([[5.0, 0.01, 0.01]], np.float32)
    volume.insert(np.array([[2.0, 0.01, 0.01]], np.float32), origin)
    places = [[1.97, 0.01, 0.01], [2.02, 0.01, 0.01]]
    assert (log_odds_at(volume, places) > 0).tolist() == [False, True]
    for _ in range(6):
        volume.insert(far.copy(), origin, ground=np.array([ground]))
    before, end = log_odds_at(volume, places)
    assert before < 0
    assert (end < 0) is not ground
