"""Scores of trajectories by relations, and by true trajectories."""

import math

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.mapping.relations import Relations, parse_relations, score, score_by_truth
from ppaas.mapping.trajectories import PlanarTrajectory

STAMPS = np.array([10.0, 11.0, 12.0])
POSES = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, math.pi / 2.0), (1.0, 1.0, math.pi / 2.0)])


def relations_of(stamps: np.ndarray, poses: np.ndarray) -> Relations:
    pairs = [(i, j) for i in range(len(poses)) for j in range(i + 1, len(poses))]
    true = [Pose2D(*poses[i]).inverse() @ Pose2D(*poses[j]) for i, j in pairs]
    return Relations(np.array([(stamps[i], stamps[j]) for i, j in pairs]), np.array(true))


def test_the_true_trajectory_has_no_error_in_any_frame_and_order():
    moved = np.array([Pose2D(3.0, -2.0, 2.5) @ Pose2D(*pose) for pose in POSES])
    found = score(relations_of(STAMPS, POSES), STAMPS[::-1], moved[::-1])
    np.testing.assert_allclose(found.translations, 0.0, atol=1e-12)
    np.testing.assert_allclose(found.rotations, 0.0, atol=1e-12)
    assert found.unmatched == 0


def test_errors_are_those_of_the_relative_poses():
    wrong = POSES.copy()
    wrong[2] += (0.0, 0.1, 0.02)
    summary = score(relations_of(STAMPS, POSES), STAMPS, wrong).summary()
    assert summary["relations"] == 3
    assert summary["mean_m"] == pytest.approx(2 * 0.1 / 3, abs=1e-5)
    assert summary["max_m"] == pytest.approx(0.1)
    assert summary["std_m"] == pytest.approx(np.std([0.0, 0.1, 0.1]), abs=1e-5)
    assert summary["max_deg"] == pytest.approx(math.degrees(0.02), abs=1e-3)


def test_a_turn_beyond_half_a_turn_is_a_small_error():
    true = Relations(np.array([(10.0, 11.0)]), np.array([(1.0, 0.0, math.pi - 0.01)]))
    poses = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, -math.pi + 0.01)])
    assert score(true, STAMPS[:2], poses).rotations == pytest.approx(0.02)


def test_relations_without_poses_near_their_stamps_are_counted():
    known = relations_of(STAMPS, POSES)
    found = score(known, STAMPS[:2], POSES[:2])
    assert (len(found.translations), found.unmatched) == (1, 2)
    with pytest.raises(InvalidInput, match=r"from 50\.00 to 52\.00 s"):
        score(known, STAMPS + 40.0, POSES)


def test_a_trajectory_of_one_pose_can_be_scored():
    known = Relations(np.array([(10.0, 10.1)]), np.zeros((1, 3)))
    assert score(known, STAMPS[:1], POSES[:1]).summary()["mean_m"] == 0.0


def test_files_are_parsed():
    found = parse_relations("# t1 t2 x y z roll pitch yaw\n\n1.5 2.5 0.1 0.2 9 9 9 0.3\n")
    np.testing.assert_array_equal(found.stamps, [(1.5, 2.5)])
    np.testing.assert_array_equal(found.poses, [(0.1, 0.2, 0.3)])


@pytest.mark.parametrize("text", ["", "# none\n", "1 2 3\n", "1 2 0 0 0 0 0 nan\n", "1 2 0 0 0 0 0 left\n"])
def test_files_that_are_not_relations_are_refused(text):
    with pytest.raises(InvalidInput, match="t1 t2 x y z roll pitch yaw"):
        parse_relations(text)


def test_a_trajectory_in_another_frame_has_the_errors_of_its_shape():
    moved = np.array([Pose2D(3.0, -2.0, 2.5) @ Pose2D(*pose) for pose in POSES])
    right = score_by_truth(PlanarTrajectory(STAMPS, POSES), PlanarTrajectory(STAMPS[::-1] + 0.01, moved[::-1]))
    assert right.summary()["rmse_m"] == pytest.approx(0.0, abs=1e-5)
    stretched = POSES * (1.5, 1.0, 1.0)
    wrong = score_by_truth(PlanarTrajectory(STAMPS, POSES), PlanarTrajectory(STAMPS, stretched))
    assert (wrong.of, len(wrong.translations), wrong.unmatched) == ("poses", 3, 0)
    assert 0.05 < wrong.summary()["rmse_m"] < 0.3


def test_true_poses_at_other_times_do_not_count():
    truth = PlanarTrajectory(np.array([10.0, 10.5, 11.0, 12.0]), np.vstack((POSES[:1], POSES)))
    assert score_by_truth(truth, PlanarTrajectory(STAMPS, POSES)).unmatched == 1
    with pytest.raises(InvalidInput, match="0 poses have a true pose"):
        score_by_truth(truth, PlanarTrajectory(STAMPS + 100.0, POSES))


def test_trajectories_without_stamps_are_compared_pose_by_pose():
    assert score_by_truth(PlanarTrajectory(None, POSES), PlanarTrajectory(None, POSES)).summary()["poses"] == 3
    for other in (PlanarTrajectory(None, POSES[:2]), PlanarTrajectory(STAMPS, POSES)):
        with pytest.raises(InvalidInput, match="has no stamps"):
            score_by_truth(PlanarTrajectory(None, POSES), other)
