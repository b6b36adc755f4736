import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.mapping import refinement
from ppaas.mapping.graph.pose_graph import Edges
from ppaas.mapping.key_frame_graph import STEP_FLOOR, edge_information
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.pipeline.offline import ScanPolisher
from ppaas.mapping.refinement import refine
from ppaas.planar_poses import relative
from tests.support.world.room_scans import CORRIDOR, LASER, scan_at

rng = np.random.default_rng(1)
TRUE = np.column_stack((np.linspace(-2.0, 2.0, 15), rng.uniform(-0.3, 0.3, 15), rng.uniform(-0.5, 0.5, 15)))
OFF = rng.normal(0.0, (0.04, 0.04, 0.02), (15, 3))
OFF[0] = 0.0


@pytest.fixture(scope="module")
def frames():
    frames = KeyFrames(LASER)
    for number, pose in enumerate(TRUE):
        frames.add(scan_at(pose, noise=0.005, seed=number), 10 * number, Pose2D(*pose), np.zeros(6))
    return frames


def odometry_of(poses, deviation):
    measured = relative(poses[:-1], poses[1:])
    information = np.tile((deviation**-2, 0.0, 0.0, deviation**-2, 0.0, deviation**-2), (len(measured), 1))
    first = np.arange(len(measured))
    return Edges(
        first, first + 1, measured, edge_information(measured, information, STEP_FLOOR), np.zeros(len(first), np.uint8)
    )


def test_poses_become_true_and_the_first_stays(frames):
    refined = refine(frames, TRUE + OFF, odometry_of(TRUE + OFF, 0.1))
    np.testing.assert_allclose(refined.poses[0], TRUE[0], atol=1e-12)
    assert np.abs(refined.poses - TRUE).max() < 0.01
    assert refined.pairs > 50
    assert refined.distance < 0.01


def test_pairs_give_the_same_poses_in_chunks_and_all_at_once(frames, monkeypatch):
    whole = refine(frames, TRUE + OFF, odometry_of(TRUE + OFF, 0.1))
    monkeypatch.setattr(refinement, "CHUNK", 7)
    parts = refine(frames, TRUE + OFF, odometry_of(TRUE + OFF, 0.1))
    np.testing.assert_array_equal(parts.poses, whole.poses)
    assert (parts.pairs, parts.distance) == (whole.pairs, pytest.approx(whole.distance))


@pytest.mark.parametrize("calls", [1, 3, 4])
def test_a_refinement_that_is_cancelled_ends_at_the_last_step(frames, calls):
    asked = []
    odometry = odometry_of(TRUE + OFF, 0.1)
    refined = refine(frames, TRUE + OFF, odometry, cancelled=lambda: asked.append(None) or len(asked) >= calls)
    assert (len(asked), refined.iterations) == (calls, max(0, calls - 2))


def test_odometry_holds_poses_that_scans_do_not_determine(frames):
    empty = KeyFrames(LASER)
    for number, pose in enumerate(TRUE):
        scan = frames.scan_points(number)
        empty.add(scan._replace(valid=np.zeros_like(scan.valid)), number, Pose2D(*pose), np.zeros(6))
    refined = refine(empty, TRUE + OFF, odometry_of(TRUE, 0.01))
    assert np.abs(refined.poses - TRUE).max() < 0.01
    assert refined.pairs == 0


def test_noise_does_not_change_the_length_of_a_corridor():
    true = np.column_stack((0.3 * np.arange(30), np.zeros(30), np.zeros(30)))
    frames = KeyFrames(LASER)
    for number, pose in enumerate(true):
        scan = scan_at(pose, walls=CORRIDOR, noise=0.01, seed=number)
        frames.add(scan, number, Pose2D(*pose), np.zeros(6))
    refined = refine(frames, true, odometry_of(true, 0.01))
    assert np.abs(refined.poses - true).max() < 0.03
    assert refined.pairs > 200


def test_single_key_frame_stays():
    frames = KeyFrames(LASER)
    frames.add(scan_at(TRUE[0]), 0, Pose2D(*TRUE[0]), np.zeros(6))
    refined = refine(frames, TRUE[:1], odometry_of(TRUE[:1], 0.1))
    np.testing.assert_array_equal(refined.poses, TRUE[:1])
    assert refined.iterations == 0


def test_scan_is_polished_without_its_own_key_frame(frames):
    poses = np.concatenate([TRUE[[7]], TRUE[[7]] + (0.03, -0.03, 0.01), [(90.0, 0.0, 0.0)]])
    numbered = np.zeros((71, 3))
    numbered[[70, 5, 6]] = poses[[1, 1, 2]]
    polisher = ScanPolisher(frames, TRUE, numbered)
    scan = scan_at(TRUE[7], noise=0.005, seed=99)
    for number in (70, 5):
        assert polisher.polish(number, scan) == pytest.approx(TRUE[7], abs=0.01)
    assert polisher.polish(6, scan) == Pose2D(90.0, 0.0, 0.0)  # no key frame is near
