"""Views of scans in a room, what another laser saw at their points; passes of a place."""

import math

import numpy as np
import pytest

from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.lifelong.neighbourhood import PointSighting, ScanViews
from ppaas.mapping.lifelong.parameters import LifelongParameters
from ppaas.mapping.lifelong.passes import divided_passes, mileage
from tests.support.world.room_scans import ALL_ROUND, LASER, ROOM, scan_at, segments

BOX = segments([(1.0, -0.5), (1.6, -0.5), (1.6, 0.1), (1.0, 0.1)])
FIRST, OTHER = Pose2D(-0.5, -0.2, 0.1), Pose2D(-0.3, -0.4, 0.2)
CLOCKWISE = LaserGeometry(np.pi / 2.0, -np.pi / 180.0, 181)


def compared(laser, first_walls, other_walls):
    frames = KeyFrames(laser)
    for pose, walls in ((FIRST, first_walls), (OTHER, other_walls)):
        frames.add(scan_at(pose, laser, walls, noise=0.01), len(frames), pose, np.zeros(6))
    views = ScanViews(frames, frames.poses).compare(np.array([0]), np.array([1]))
    points = frames.points[0]
    c, s = np.cos(FIRST.theta), np.sin(FIRST.theta)
    x, y = FIRST.x + c * points[:, 0] - s * points[:, 1], FIRST.y + s * points[:, 0] + c * points[:, 1]
    on_box = (np.abs(x - 1.3) < 0.35) & (np.abs(y + 0.2) < 0.35)
    return views.seen[0], views.blocked[0], on_box


WITH = np.concatenate((ROOM, BOX))


@pytest.mark.parametrize("laser", [LASER, ALL_ROUND, CLOCKWISE])
def test_the_same_room_is_confirmed(laser):
    seen, blocked, _ = compared(laser, WITH, WITH)
    assert (seen == PointSighting.CONFIRMED).mean() > 0.75
    assert (seen == PointSighting.EMPTY).sum() + blocked.sum() <= 4


@pytest.mark.parametrize("laser", [LASER, ALL_ROUND, CLOCKWISE])
def test_the_other_laser_looks_through_the_place_of_a_box_that_left(laser):
    seen, blocked, on_box = compared(laser, WITH, ROOM)
    assert (seen[on_box] == PointSighting.EMPTY).mean() > 0.8
    assert (seen[~on_box] == PointSighting.EMPTY).sum() + blocked.sum() <= 4


@pytest.mark.parametrize("laser", [LASER, ALL_ROUND, CLOCKWISE])
def test_a_new_box_blocks_the_beams_that_passed_its_place(laser):
    _, blocked, _ = compared(laser, ROOM, WITH)
    behind = compared(laser, WITH, WITH)[2]
    assert blocked[behind].mean() > 0.5
    assert blocked[~behind].sum() <= 4


def test_scans_of_few_beams_have_no_opinion():
    frames = KeyFrames(LaserGeometry(0.0, 0.1, 2))
    for number in range(2):
        frames.add(scan_at(FIRST, frames.geometry), number, FIRST, np.zeros(6))
    views = ScanViews(frames, frames.poses).compare(np.array([0]), np.array([1]))
    assert not views.seen.any() and not views.blocked.any()


def test_mileage_counts_distances_and_turns():
    poses = np.array([(0.0, 0.0, 0.0), (3.0, 4.0, 0.0), (3.0, 4.0, 1.0)])
    np.testing.assert_allclose(mileage(poses), (0.0, 5.0, 5.5))


def test_a_place_is_passed_again_after_some_distance():
    assert divided_passes(np.array([0.0, 0.5, 1.0, 8.0, 8.5, 20.0]), 6.0).tolist() == [0, 0, 0, 1, 1, 2]
    assert divided_passes(np.array([3.0]), 6.0).tolist() == [0]


@pytest.mark.parametrize(
    "given",
    [{"lifelong_iou_match": 0.0}, {"lifelong_iou_match": 1.5}, {"pass_distance": math.nan}, {"least_new_frames": -1}],
)
def test_values_out_of_range_are_refused(given):
    with pytest.raises(InvalidParameter, match=next(iter(given))):
        LifelongParameters(**given)
