import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.mapping.alignment import CHECKING, CorrelationGrid, Prior, Window, align
from ppaas.mapping.kernels import correlation as kernels
from ppaas.mapping.key_frames import KeyFrames, NearFrames
from ppaas.planar_poses import symmetric
from tests.reference.mapping import scans as twin
from tests.support.world.room_scans import ALL_ROUND, CORRIDOR, LASER, ROOM, scan_at

POSES = np.array([(0.0, 0.0, 0.0), (0.3, 0.1, 0.1), (-0.2, 0.2, -0.1)])


def frames_at(poses, laser=LASER, walls=ROOM):
    frames = KeyFrames(laser)
    for number, pose in enumerate(poses):
        frames.add(scan_at(pose, laser, walls, 0.005, number), number, Pose2D(*pose), np.zeros(6))
    return frames


@pytest.mark.parametrize("laser", [LASER, ALL_ROUND])
@given(st.integers(0, 2**32 - 1))
def test_scan_is_aligned_to_millimetres(laser, seed):
    frames = frames_at(POSES, laser)
    rng = np.random.default_rng(seed)
    true = rng.uniform((-0.3, -0.3, -0.3), (0.3, 0.3, 0.3))
    start = true + rng.uniform((-0.15, -0.15, -0.1), (0.15, 0.15, 0.1))
    aligned = align(scan_at(true, laser, noise=0.005, seed=seed), Pose2D(*start), frames, frames.latest(3))
    assert np.abs(np.array(aligned.pose) - true).max() < 0.01
    assert aligned.ratio > 0.7
    assert aligned.pairs > 1.5 * laser.beams


def test_poses_of_key_frames_are_those_given():
    frames = frames_at(POSES)
    moved = Pose2D(5.0, -3.0, 2.0)
    near = NearFrames(np.array([2, 0]), np.array([moved @ Pose2D(*POSES[2]), moved @ Pose2D(*POSES[0])]))
    aligned = align(scan_at((0.1, 0.1, 0.05)), moved @ Pose2D(0.15, 0.1, 0.02), frames, near)
    assert aligned.pose == pytest.approx(moved @ Pose2D(0.1, 0.1, 0.05), abs=0.01)


def test_corridor_is_not_determined_along_its_axis_and_the_prior_decides():
    frames = frames_at([(0.0, 0.0, 0.0)], walls=CORRIDOR)
    scan = scan_at((0.5, 0.2, 0.0), walls=CORRIDOR)
    free = align(scan, Pose2D(0.3, 0.15, 0.02), frames, frames.latest(1))
    assert free.pose.x == pytest.approx(0.3, abs=0.02)
    assert free.pose.y == pytest.approx(0.2, abs=0.01)
    deviations = np.sqrt(np.diag(np.linalg.inv(symmetric(free.information))))
    assert deviations[0] > 30.0 * deviations[1]
    prior = Prior(Pose2D(0.6, 0.1, 0.0), (0.01, 0.1, 0.1))
    held = align(scan, Pose2D(0.3, 0.15, 0.02), frames, frames.latest(1), prior=prior)
    assert held.pose == pytest.approx((0.6, 0.2, 0.0), abs=0.01)


def test_information_of_the_prior_is_added():
    frames = frames_at(POSES)
    start, scan = Pose2D(0.0, 0.0, 0.0), scan_at((0.0, 0.0, 0.0))
    without = align(scan, start, frames, frames.latest(3))
    prior = align(scan, start, frames, frames.latest(3), prior=Prior(start, (0.1, 0.2, 0.5)))
    added = prior.information - without.information
    np.testing.assert_allclose(added[[0, 3, 5]], (100.0, 25.0, 4.0), atol=0.02 * without.information.max())


def test_pose_stays_without_key_frames_or_readings():
    frames, start = frames_at(POSES), Pose2D(0.1, -0.2, 0.3)
    empty = scan_at((0.0, 0.0, 0.0))._replace(valid=np.zeros(181, np.bool_))
    for scan, near in ((empty, frames.latest(3)), (scan_at((0.0, 0.0, 0.0)), frames.latest(0))):
        aligned = align(scan, start, frames, near, CHECKING)
        assert aligned.pose == pytest.approx(start)
        assert (aligned.ratio, aligned.pairs) == (0.0, 0)


@pytest.mark.parametrize("off", [(0.0, 0.0, 0.0), (0.3, -0.2, 0.1), (-0.4, 0.35, -0.2)])
def test_start_is_found_to_a_cell(off):
    frames = KeyFrames(LASER)
    frames.add(scan_at((0.0, 0.0, 0.0)), 0, Pose2D(0.0, 0.0, 0.0), np.zeros(6))
    grid = CorrelationGrid(0.05, 0.05)
    grid.draw(frames, frames.latest(1), Pose2D(0.0, 0.0, 0.0))
    true = np.array((0.2, 0.1, 0.15))
    found, fit = grid.search(scan_at(true), Pose2D(*(true + off)), Window(0.5, 0.3, 0.02))
    assert np.abs(np.array(found) - true).max() < 0.06
    assert fit > 0.7


def test_drawing_replaces_the_grid():
    frames = KeyFrames(LASER)
    frames.add(scan_at((0.0, 0.0, 0.0)), 0, Pose2D(0.0, 0.0, 0.0), np.zeros(6))
    grid = CorrelationGrid(0.1, 0.1, 10.0)
    grid.draw(frames, frames.latest(1), Pose2D(0.0, 0.0, 0.0))
    grid.draw(frames, frames.latest(0), Pose2D(0.0, 0.0, 0.0))
    blind = scan_at((0.0, 0.0, 0.0))._replace(valid=np.zeros(181, np.bool_))
    for scan in (scan_at((0.0, 0.0, 0.0)), blind):
        assert grid.search(scan, Pose2D(0.1, 0.2, 0.3), Window(0.2, 0.1, 0.05))[1] == 0.0


def test_walls_are_drawn_without_gaps_so_that_scores_are_nearly_the_same_along_a_corridor():
    near = scan_at((0.0, 0.01, 0.0), walls=CORRIDOR)
    near = near._replace(valid=near.valid & (np.hypot(*near.points.T) < 4.0))
    dropped = []
    for scan in (near, near._replace(normals=np.zeros_like(near.normals))):
        frames = KeyFrames(LASER)
        frames.add(scan, 0, Pose2D(0.0, 0.01, 0.0), np.zeros(6))
        grid = CorrelationGrid(0.05, 0.05)
        grid.draw(frames, frames.latest(1), Pose2D(0.0, 0.023, 0.0))
        fits = [grid.search(near, Pose2D(x, 0.01, 0.0), Window(0.0, 0.0, 0.1))[1] for x in (0.0, 0.2, 0.4)]
        dropped.append(np.ptp(fits))
    joined, single = dropped
    assert joined < 0.3 * single


seeds = st.integers(0, 2**32 - 1)
BLUR = np.array([(90, 150, 90), (150, 255, 150), (90, 150, 90)], np.uint8)


def frames(rng):
    points = rng.uniform(-3.0, 3.0, (3, 20, 2)).astype(np.float32)
    return rng.uniform(-1.0, 1.0, (3, 3)), points, rng.random((3, 20)) < 0.8


@given(seeds)
def test_grid_agrees_with_the_twin(seed):
    poses, points, valid = frames(np.random.default_rng(seed))
    grid = np.full((50, 60), 7, np.uint8)
    no_normals = np.zeros_like(points)
    kernels.draw(grid, -2.5, -2.0, 0.1, BLUR, np.array([2, 0]), poses[:2], points, no_normals, valid)
    expected = twin.draw(grid.shape, -2.5, -2.0, 0.1, BLUR, poses[:2], points[[2, 0]], valid[[2, 0]])
    assert (grid != expected).mean() < 0.01  # points on the edge of a cell may be rounded to either side


def test_points_on_one_line_are_joined_and_others_are_not():
    points = np.array([[(-1.0, 1.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.5)]], np.float32)
    normals = np.array([[(0.0, -1.0), (0.0, -1.0), (0.0, -1.0), (-1.0, 0.0)]], np.float32)
    grid = np.zeros((40, 40), np.uint8)
    for valid, columns in (((True, True, True, True), range(10, 31)), ((True, False, True, True), (10, 30))):
        kernels.draw(
            grid, -2.05, -2.05, 0.1, np.array([[255]], np.uint8), np.zeros(1, np.int64), np.zeros((1, 3)),
            points, normals, np.array([valid]),
        )  # fmt: skip
        np.testing.assert_array_equal(np.flatnonzero(grid[30]), columns)
        assert np.count_nonzero(grid) == len(columns) + 1


@given(seeds)
def test_search_returns_the_best_pose_of_the_window(seed):
    rng = np.random.default_rng(seed)
    grid = rng.integers(0, 255, (50, 60)).astype(np.uint8)
    points, valid = rng.uniform(-2.0, 2.0, (30, 2)).astype(np.float32), rng.random(30) < 0.8
    start = rng.uniform(-0.5, 0.5, 3)
    pose, score = kernels.search(grid, -2.5, -2.0, 0.1, points, valid, 3, start, 2, 3, 0.05)
    used = points[::3][valid[::3]]

    def rated(u, v, a):
        at = start + np.array((u * 0.1, v * 0.1, a * 0.05))
        found = twin.score(grid, -2.5, -2.0, 0.1, used, at) if len(used) else 0.0
        return found * (1.0 - 0.05 * ((u * u + v * v) / 5.0 + a * a / 10.0)), found

    steps = [(u, v, a) for a in range(-3, 4) for v in range(-2, 3) for u in range(-2, 3)]
    best = max(rated(*step)[0] for step in steps)
    chosen = np.round((pose - start) / (0.1, 0.1, 0.05)).astype(int)
    # A cell of difference where rounding decides.
    assert rated(*chosen)[0] >= best - 1.0 / max(len(used), 1)
    assert abs(score - rated(*chosen)[1]) <= 1.0 / max(len(used), 1)
