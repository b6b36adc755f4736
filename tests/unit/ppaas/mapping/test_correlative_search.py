import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.mapping.alignment import CorrelationGrid, Window
from ppaas.mapping.key_frames import KeyFrames
from tests.support.world.room_scans import CORRIDOR, LASER, scan_at


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
