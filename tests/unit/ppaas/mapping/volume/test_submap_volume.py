"""3D maps that move with key frames: equality with OctoMap before, and exactness after a correction."""

import math

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.mapping.volume.key_frame_poses import KeyFramePoses
from ppaas.mapping.volume.parameters import VolumeParameters
from ppaas.mapping.volume.submap_volume import SUBMAP_TRAVEL, SubmapVolume
from ppaas.mapping.volume.voxel_volume import VoxelVolume
from tests.unit.ppaas.mapping.volume.test_voxel_volume import log_odds, log_odds_at

PARAMETERS = VolumeParameters(resolution=0.1, max_range=6.0)
STOPS = np.arange(0.0, 12.1, 2.0)
HALL = np.array([[-3.0, 15.0], [-2.0, 2.0], [-0.5, 2.0]])


def scan(place):
    """Return what a sensor at a place of a hall sees, points (n, 3)."""
    turn, rise = np.meshgrid(np.linspace(-math.pi, math.pi, 160), np.linspace(-0.6, 0.6, 24))
    rays = np.stack([np.cos(turn) * np.cos(rise), np.sin(turn) * np.cos(rise), np.sin(rise)], axis=-1).reshape(-1, 3)
    with np.errstate(divide="ignore"):
        reach = np.where(rays > 0.0, HALL[:, 1] - place, HALL[:, 0] - place) / rays
    return place + rays * reach.min(axis=1)[:, None]


def moved(points, pose):
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    turned = np.stack([c * points[..., 0] - s * points[..., 1], s * points[..., 0] + c * points[..., 1]], axis=-1)
    return np.concatenate((turned + np.array([pose.x, pose.y]), points[..., 2:]), axis=-1).astype(np.float32)


def drift(index):
    """Return the error of the pose at a stop, about the origin; it is that of its submap."""
    first = index - index % 2
    return Pose2D(0.02 * first, 0.1 * first, 0.02 * first)


TRUE = KeyFramePoses(np.arange(len(STOPS), dtype=float), np.stack([STOPS, 0 * STOPS, 0 * STOPS], axis=1))
DRIFTED = KeyFramePoses(TRUE.stamps, np.array([drift(i) @ Pose2D(x, 0.0) for i, x in enumerate(STOPS)]))


def driven(key_frames, parameters=PARAMETERS):
    volume = SubmapVolume(parameters)
    for index, x in enumerate(STOPS):
        anchor, place = key_frames.anchor(float(index)), np.array([x, 0.0, 0.5])
        motion = anchor.pose @ Pose2D(x, 0.0).inverse()
        volume.insert(moved(scan(place), motion), moved(place, motion), anchor)
    return volume


@pytest.fixture(scope="module")
def fresh():
    volume = VoxelVolume(PARAMETERS)
    for x in STOPS:
        place = np.array([x, 0.0, 0.5])
        volume.insert(scan(place).astype(np.float32), place)
    return log_odds(volume)


def occupied(voxels):
    return np.array([key for key, value in voxels.items() if value >= 0.0])


def part_near(keys, others):
    """Return the part of keys (n, 3) that are at most a voxel from one of the others."""
    around = np.stack(np.meshgrid(*[(-1, 0, 1)] * 3), axis=-1).reshape(-1, 3)
    near = {tuple(key) for key in (others[:, None] + around).reshape(-1, 3).tolist()}
    return np.mean([tuple(key) in near for key in keys.tolist()])


def test_a_copy_with_moved_key_frames_is_the_map_as_if_they_had_moved():
    volume = driven(DRIFTED)
    before = log_odds(volume.volume)
    copy = volume.moved(DRIFTED, DRIFTED.poses, TRUE.poses)
    assert log_odds(volume.volume) == before
    volume.correct(DRIFTED, TRUE)
    assert log_odds(copy) == log_odds(volume.volume)
    fixed = SubmapVolume(PARAMETERS)
    fixed.insert(scan(np.array([0.0, 0.0, 0.5])).astype(np.float32), [0.0, 0.0, 0.5])
    assert fixed.moved(TRUE, TRUE.poses, DRIFTED.poses).blocks is fixed.volume.blocks


def test_map_is_that_of_octomap_as_long_as_no_loop_is_closed(fresh):
    volume = driven(TRUE)
    assert log_odds(volume.volume) == fresh
    assert len(volume.submaps) == math.ceil(len(STOPS) / 2)
    assert not volume.correct(TRUE, TRUE)
    assert log_odds(volume.volume) == fresh


def test_corrected_map_is_that_of_the_corrected_poses_within_a_voxel(fresh):
    volume = driven(DRIFTED)
    assert volume.correct(DRIFTED, TRUE)
    found, wanted = occupied(log_odds(volume.volume)), occupied(fresh)
    for ours, theirs in ((found, wanted), (wanted, found)):
        assert part_near(ours, theirs) >= 0.998
    after = log_odds(volume.volume)
    same = sum((after.get(key, np.nan) >= 0.0) == (value >= 0.0) for key, value in fresh.items())
    assert same >= 0.93 * len(fresh)


def test_corrections_there_and_back_do_not_blur_the_map(fresh):
    volume = driven(TRUE)
    for before, after in ((TRUE, DRIFTED), (DRIFTED, TRUE)):
        assert volume.correct(before, after)
    found = log_odds(volume.volume)
    assert found.keys() == fresh.keys()
    assert occupied(found).tolist() == [key for key in occupied(found).tolist() if fresh[tuple(key)] >= 0.0]


def test_clouds_after_a_correction_hang_on_a_new_submap():
    volume, before = driven(DRIFTED), len(driven(DRIFTED).submaps)
    volume.correct(DRIFTED, TRUE)
    place = np.array([STOPS[-1], 0.0, 0.5])
    volume.insert(scan(place).astype(np.float32), place, TRUE.anchor(STOPS[-1]))
    assert len(volume.submaps) == before + 1
    assert volume.submaps[-1].motion == Pose2D(0.0, 0.0, 0.0)


def test_clouds_without_key_frames_make_no_submap():
    volume = SubmapVolume(PARAMETERS)
    place = np.array([0.0, 0.0, 0.5])
    volume.insert(scan(place).astype(np.float32), place)
    assert (len(volume.submaps), len(volume)) == (0, len(volume.volume.blocks))


def test_clouds_before_the_first_key_frame_move_with_it():
    volume = SubmapVolume(PARAMETERS)
    begin, end = np.array([0.0, 0.0, 0.5]), np.array([STOPS[-1], 0.0, 0.5])
    volume.insert(scan(begin).astype(np.float32), begin)
    volume.insert(scan(end).astype(np.float32), end, TRUE.anchor(0.0))
    least = occupied(log_odds(volume.volume)).min(axis=0)
    assert volume.correct(TRUE, KeyFramePoses(TRUE.stamps, TRUE.poses + np.array([0.3, 0.0, 0.0])))
    assert (occupied(log_odds(volume.volume)).min(axis=0) - least).tolist() == [3, 0, 0]


def test_submaps_are_joined_if_there_are_too_many_blocks(fresh):
    needed = len(driven(TRUE))
    volume = driven(TRUE, VolumeParameters(resolution=0.1, max_range=6.0, max_blocks=int(0.9 * needed)))
    assert volume.joined > 0
    assert len(volume) <= 0.9 * needed
    assert log_odds(volume.volume) == fresh


def test_a_map_of_half_the_blocks_or_more_no_longer_moves(fresh):
    parameters = VolumeParameters(resolution=0.1, max_range=6.0, max_blocks=len(driven(TRUE).volume.blocks) + 5)
    volume = driven(TRUE, parameters)
    assert volume.fixed
    assert not volume.submaps
    assert log_odds(volume.volume) == fresh
    volume.clear()
    assert (volume.fixed, len(volume)) == (False, 0)


def test_a_cleared_box_stays_clear_after_a_correction():
    volume = driven(DRIFTED)
    end = drift(len(STOPS) - 1) @ Pose2D(15.0, 0.0)
    volume.clear_box((end.x - 2.0, end.y - 2.0, 0.0), (end.x + 2.0, end.y + 2.0, 1.0))
    volume.correct(DRIFTED, TRUE)
    wall = np.stack(np.meshgrid([15.05, 14.95], np.arange(-0.5, 0.5, 0.1), np.arange(0.2, 0.8, 0.1)), -1).reshape(-1, 3)
    assert not (log_odds_at(volume.volume, wall) >= 0.0).any()


def test_submaps_begin_after_their_travel():
    assert np.diff(STOPS).max() < SUBMAP_TRAVEL
