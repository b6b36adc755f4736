"""Submaps: their motion against a twin, and the addition of their voxels."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.mapping.volume.blocks import VoxelBlocks
from ppaas.mapping.volume.parameters import VolumeParameters
from ppaas.mapping.volume.submap import Submap, add_log_odds, moved
from ppaas.mapping.volume.voxel_volume import VoxelVolume
from tests.reference.mapping.volume import moved_voxels
from tests.support.budget import examples
from tests.unit.ppaas.mapping.volume.test_voxel_volume import cloud, log_odds

PARAMETERS = VolumeParameters(resolution=0.1)
MODEL = PARAMETERS.model()


@pytest.fixture(scope="module")
def volume():
    result = VoxelVolume(PARAMETERS)
    result.insert(*cloud(1, 30, 0.5))
    return result


def as_volume(codes, values):
    result = VoxelVolume(PARAMETERS)
    result.blocks = VoxelBlocks(10_000)
    add_log_odds(result.blocks, codes, values, MODEL)
    return log_odds(result)


@settings(max_examples=examples(15), deadline=None)
@given(st.integers(-5000, 5000), st.integers(-5000, 5000), st.floats(-math.pi, math.pi))
def test_moved_blocks_are_those_of_the_twin(volume, x, y, angle):
    x, y = 1e-3 * x + 0.317e-3, 1e-3 * y + 0.713e-3  # else many centres may be on the border of two voxels at once
    found = as_volume(*moved(volume.blocks, Pose2D(x, y, angle), 0.1))
    wanted = moved_voxels(log_odds(volume), (x, y, angle), 0.1)
    different = {key for key in found.keys() | wanted.keys() if found.get(key) != wanted.get(key)}
    assert len(different) <= 1e-3 * len(wanted)


def test_a_motion_by_whole_voxels_is_exact(volume):
    found = as_volume(*moved(volume.blocks, Pose2D(0.3, -1.7, math.pi / 2.0), 0.1))
    assert sorted(found.values()) == sorted(log_odds(volume).values())


def test_blocks_that_leave_the_range_of_keys_are_lost(volume):
    codes, _ = moved(volume.blocks, Pose2D(3276.5, 0.0, 0.0), 0.1)
    assert 0 < len(codes) < len(volume.blocks)
    assert not len(moved(volume.blocks, Pose2D(9e3, 0.0, 0.0), 0.1)[0])


def test_log_odds_are_added_within_the_limits_of_the_model(volume):
    blocks = VoxelBlocks(1000)
    for _ in range(30):
        add_log_odds(blocks, volume.blocks.codes, volume.blocks.log_odds, MODEL)
    known = blocks.log_odds[~np.isnan(blocks.log_odds)]
    assert set(known.tolist()) == {float(MODEL.least), float(MODEL.most)}
    assert np.array_equal(np.isnan(blocks.log_odds), np.isnan(volume.blocks.log_odds))


def test_joined_submaps_have_the_voxels_of_both_where_they_are(volume):
    first, second = Submap(1, 1.0, 1000), Submap(2, 2.0, 1000)
    for submap in (first, second):
        add_log_odds(submap.blocks, volume.blocks.codes, volume.blocks.log_odds, MODEL)
    second.motion = Pose2D(12.8, 0.0, 0.0)
    before = as_volume(*first.placed(0.1)) | as_volume(*second.placed(0.1))
    first.join(second, MODEL, 0.1)
    assert as_volume(*first.placed(0.1)) == before


def test_a_small_motion_leaves_the_voxels_in_place(volume):
    submap = Submap(1, 1.0, 1000)
    add_log_odds(submap.blocks, volume.blocks.codes, volume.blocks.log_odds, MODEL)
    submap.motion = Pose2D(0.02, 0.0, 0.0)
    assert submap.placed(0.1)[1] is not None
    assert np.array_equal(submap.placed(0.1)[0], submap.blocks.codes)
    assert submap.reach_of_motion(Pose2D(0.0, 0.0, math.pi), 0.1) > 1.0
    assert Submap(1, 1.0, 10).reach_of_motion(Pose2D(1.0, 0.0, 0.0), 0.1) == 0.0
