"""Blocks of voxels and the key frames that carry them: submaps, cleared boxes, projected maps, anchors of clouds."""

import math

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.errors import InvalidInput, InvalidMap, InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.mapping.volume.blocks import VoxelBlocks, clear_box
from ppaas.mapping.volume.exports import project_volume
from ppaas.mapping.volume.key_frame_poses import NO_KEY_FRAMES, KeyFramePoses
from ppaas.mapping.volume.parameters import VolumeParameters
from ppaas.mapping.volume.submap import VolumeSubmap, add_log_odds, moved
from ppaas.mapping.volume.voxel_volume import VoxelVolume
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN
from ppaas.parameters import read_parameters
from tests.reference.mapping.volume import MIDDLE, moved_voxels, projected
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
    first, second = VolumeSubmap(1, 1.0, 1000), VolumeSubmap(2, 2.0, 1000)
    for submap in (first, second):
        add_log_odds(submap.blocks, volume.blocks.codes, volume.blocks.log_odds, MODEL)
    second.motion = Pose2D(12.8, 0.0, 0.0)
    before = as_volume(*first.placed(0.1)) | as_volume(*second.placed(0.1))
    first.join(second, MODEL, 0.1)
    assert as_volume(*first.placed(0.1)) == before


def test_a_small_motion_leaves_the_voxels_in_place(volume):
    submap = VolumeSubmap(1, 1.0, 1000)
    add_log_odds(submap.blocks, volume.blocks.codes, volume.blocks.log_odds, MODEL)
    submap.motion = Pose2D(0.02, 0.0, 0.0)
    assert submap.placed(0.1)[1] is not None
    assert np.array_equal(submap.placed(0.1)[0], submap.blocks.codes)
    assert submap.reach_of_motion(Pose2D(0.0, 0.0, math.pi), 0.1) > 1.0
    assert VolumeSubmap(1, 1.0, 10).reach_of_motion(Pose2D(1.0, 0.0, 0.0), 0.1) == 0.0


@pytest.mark.parametrize("motion", [Pose2D(0.0, 0.0, 0.0), Pose2D(0.7, -0.2, 0.6)])
def test_known_voxels_with_their_centre_in_the_box_become_free(motion):
    volume = VoxelVolume(PARAMETERS)
    volume.insert(*cloud(2, 60, 1.0))
    before = log_odds(volume)
    low, high = np.array([-0.6, -0.4, -0.5]), np.array([0.8, 0.9, 0.7])
    clear_box(volume.blocks, high, low, PARAMETERS, motion)
    c, s = math.cos(motion.theta), math.sin(motion.theta)
    wanted = {}
    for key, value in before.items():
        x, y, z = (np.array(key) + 0.5 - MIDDLE) * 0.1
        place = np.array([c * x - s * y + motion.x, s * x + c * y + motion.y, z])
        wanted[key] = PARAMETERS.model().least if ((place >= low) & (place <= high)).all() else value
    assert log_odds(volume) == wanted
    assert wanted != before


def test_a_box_that_is_not_finite_is_refused():
    with pytest.raises(InvalidInput, match="must be finite"):
        clear_box(VoxelVolume(PARAMETERS).blocks, (0.0, 0.0, math.nan), (1.0, 1.0, 1.0), PARAMETERS)


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


def test_names_are_those_of_octomap_server():
    given = {"resolution": 0.1, "sensor_model.max_range": 5.0, "sensor_model.hit": 0.8, "occupancy_min_z": -0.5}
    parameters = read_parameters(VolumeParameters, "octomap_server", given)
    assert (parameters.resolution, parameters.max_range, parameters.hit) == (0.1, 5.0, 0.8)


def test_log_odds_are_those_of_octomap():
    model = VolumeParameters().model()
    assert all(value.dtype == np.float32 for value in model)
    assert np.allclose(model, [0.8472979, -0.4054651, -1.9924302, 3.4760987])


@pytest.mark.parametrize(
    "wrong",
    [
        {"resolution": 0.0}, {"max_range": 0.0}, {"max_range": -2.0}, {"hit": 0.4}, {"hit": 1.0}, {"miss": 0.6},
        {"miss": 0.0}, {"min": 0.6}, {"max": 0.4}, {"max": 1.0}, {"max_blocks": 0}, {"occupancy_min_z": float("nan")},
    ],
)  # fmt: skip
def test_numbers_out_of_range_are_refused(wrong):
    with pytest.raises(InvalidParameter):
        VolumeParameters(**wrong)


BEFORE = KeyFramePoses(np.array([1.0, 2.0, 3.0]), np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]))


@pytest.mark.parametrize(("stamp", "anchor"), [(0.5, 1.0), (1.0, 1.0), (1.9, 1.0), (2.0, 2.0), (9.0, 3.0)])
def test_a_cloud_hangs_on_the_last_key_frame_before_it(stamp, anchor):
    assert BEFORE.anchor(stamp).stamp == anchor


def test_motion_is_that_of_the_key_frame_or_of_the_nearest_one_left():
    after = KeyFramePoses(np.array([1.0, 3.0, 4.0]), np.array([[0.0, 0.0, 0.0], [2.0, 1.0, 0.5], [3.0, 0.0, 0.0]]))
    assert after.differs(BEFORE)
    assert after.motion_since(BEFORE, 1.0) == Pose2D(0.0, 0.0, 0.0)
    for stamp in (2.5, 3.0):
        assert after.motion_since(BEFORE, stamp) @ Pose2D(2.0, 0.0, 0.0) == pytest.approx(Pose2D(2.0, 1.0, 0.5))


def test_a_key_frame_more_is_no_difference():
    after = KeyFramePoses(np.append(BEFORE.stamps, 4.0), np.vstack((BEFORE.poses, [[5.0, 5.0, 0.0]])))
    assert not after.differs(BEFORE)


def test_without_common_key_frames_nothing_moves():
    other = KeyFramePoses(BEFORE.stamps + 10.0, BEFORE.poses + 1.0)
    assert other.differs(BEFORE)
    assert other.motion_since(BEFORE, 2.0) == Pose2D(0.0, 0.0, 0.0)
    assert not len(NO_KEY_FRAMES)


@pytest.mark.parametrize(
    ("moved", "jumps"), [((0.4, 0.0, 0.1), False), ((0.6, 0.0, 0.0), True), ((0.0, 0.0, 0.4), True)]
)
def test_frame_has_jumped_if_the_last_key_frame_moved_far(moved, jumps):
    before = KeyFramePoses(np.array([1.0, 2.0]), np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]))
    motion = Pose2D(*moved)
    poses = np.array([motion @ Pose2D(*pose) for pose in before.poses.tolist()])
    after = KeyFramePoses(np.array([1.0, 2.0, 3.0]), np.vstack((poses, [[5.0, 0.0, 0.0]])))
    found = after.jump_since(before)
    assert (found is not None) is jumps
    if found is not None:
        np.testing.assert_allclose(found, motion, atol=1e-12)
    assert after.jump_since(NO_KEY_FRAMES) is None
    assert NO_KEY_FRAMES.jump_since(before) is None
