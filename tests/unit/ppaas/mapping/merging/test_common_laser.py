import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.merging.common_laser import SAME, are_same, common_geometry, joined_frames
from tests.support.world.room_scans import ALL_ROUND, LASER, scan_at

FINE = LaserGeometry(-math.pi / 4.0, math.pi / 720.0, 361, Pose2D(0.2, 0.0))
CLOCKWISE = LaserGeometry(math.pi / 2.0, -math.pi / 180.0, 181)


def frames_of(laser, count=3):
    frames = KeyFrames(laser)
    for k in range(count):
        frames.add(scan_at((0.1 * k, 0.0, 0.3), laser), 2 * k, Pose2D(0.1 * k, 0.0, 0.3), np.full(6, float(k)))
    return frames


def test_frames_of_one_laser_are_stacked_unchanged():
    first, second = frames_of(LASER), frames_of(LASER, 2)
    joined = joined_frames(first, second)
    assert joined.geometry == LASER
    np.testing.assert_array_equal(joined.points, np.concatenate((first.points, second.points)))
    np.testing.assert_array_equal(joined.poses, np.concatenate((first.poses, second.poses)))
    assert joined.scans.tolist() == [0, 2, 4, 5, 7]


@pytest.mark.parametrize("laser", [ALL_ROUND, CLOCKWISE])
def test_points_keep_their_places_at_the_beams_of_another_laser(laser):
    joined = joined_frames(frames_of(LASER), frames_of(laser))
    geometry = joined.geometry
    for row, frames in ((0, frames_of(LASER)), (3, frames_of(laser))):
        given, kept = frames.points[0][frames.valid[0]], joined.points[row][joined.valid[row]]
        assert {tuple(point) for point in kept} == {tuple(point) for point in given}
    bearings = geometry.angle_min + geometry.angle_increment * np.arange(geometry.beams)
    points, valid = joined.points[3], joined.valid[3]
    off = np.arctan2(points[valid, 1], points[valid, 0]) - bearings[valid]
    assert np.abs((off + math.pi) % (2.0 * math.pi) - math.pi).max() <= 0.51 * geometry.angle_increment


def test_the_finer_laser_keeps_all_points_and_the_coarser_one_the_nearest():
    first, second = frames_of(LASER), frames_of(FINE)
    fine, coarse = joined_frames(first, second), joined_frames(first, second, finest=False)
    assert fine.geometry.angle_increment == FINE.angle_increment
    assert fine.valid[:3].sum() == first.valid.sum()
    assert fine.valid[3:].sum() == second.valid.sum()
    assert coarse.geometry.angle_increment == LASER.angle_increment
    assert coarse.valid[3:].sum(axis=1).tolist() == [91, 91, 91]


@given(
    first=st.tuples(st.floats(-3.0, 1.0), st.floats(0.005, 0.05), st.integers(2, 100)),
    second=st.tuples(st.floats(-3.0, 1.0), st.floats(0.005, 0.05), st.integers(2, 100)),
    finest=st.booleans(),
)
def test_the_common_laser_covers_both(first, second, finest):
    one, other = (LaserGeometry(*numbers) for numbers in (first, second))
    common = common_geometry(one, other, finest=finest)
    if are_same(one, other):
        assert common == one
        return
    last = common.angle_min + common.angle_increment * (common.beams - 1)
    whole = common.beams == math.floor(2.0 * math.pi / common.angle_increment + 1e-3)
    for laser in (one, other):
        assert common.angle_min <= laser.angle_min + 1e-9
        covered = laser.angle_min + laser.angle_increment * (laser.beams - 1)
        assert whole or last >= covered - 1.1 * SAME * common.angle_increment
