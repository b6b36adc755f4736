"""Key frames as nodes of a pose graph, and the information of its edges."""

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.key_frame_graph import (
    CLOSURE_FLOOR,
    STEP_FLOOR,
    append_key_frame,
    determines_position,
    edge_information,
    forgetting,
    weakest_information,
)
from ppaas.mapping.key_frames import KeyFrames
from ppaas.planar_poses import compose, symmetric, upper_triangle
from tests.support.world.room_scans import LASER, scan_at

INFORMATION = np.array([400.0, 10.0, 5.0, 300.0, 2.0, 9000.0])


def test_each_key_frame_is_joined_with_the_one_before() -> None:
    frames, graph, steps = KeyFrames(LASER), PoseGraph(), []
    for number, pose in enumerate([Pose2D(1.0, 0.5, 0.2), Pose2D(1.3, 0.6, 0.5)]):
        frames.add(scan_at(np.array(pose)), number, pose, INFORMATION)
        steps.append(append_key_frame(graph, frames))
    assert graph.node_count == 2
    np.testing.assert_array_equal(steps[0], np.zeros(3))
    np.testing.assert_allclose(compose(graph.poses[0], steps[1]), graph.poses[1], atol=1e-9)
    edges = graph.edges
    assert [(edges.first[0], edges.second[0], edges.kinds[0])] == [(0, 1, EdgeKind.ODOMETRY)]
    np.testing.assert_array_equal(edges.measurements, [steps[1]])
    np.testing.assert_allclose(edges.information[0], edge_information(steps[1], INFORMATION, STEP_FLOOR))


def test_directions_are_turned_into_the_frame_of_the_first_node():
    information = np.array([(100.0, 0.0, 0.0, 1e4, 0.0, 1e4)])
    found = edge_information(np.array([(1.0, 2.0, np.pi / 2.0)]), information, (1e-6, 1e-6, 1e-6), correlation=1.0)
    np.testing.assert_allclose(found[0], np.diag((1e4, 100.0, 1e4)), rtol=1e-3, atol=1e-3)


@pytest.mark.parametrize("floor", [STEP_FLOOR, CLOSURE_FLOOR])
def test_no_edge_is_better_than_its_floor(floor):
    information = np.array([(1e12, 0.0, 0.0, 1e12, 0.0, 1e12)])
    covariance = np.linalg.inv(edge_information(np.array([(1.0, 0.0, 0.3)]), information, floor)[0])
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), floor, rtol=1e-3)


def test_directions_that_are_not_determined_keep_some_information():
    found = edge_information(np.zeros((2, 3)), np.zeros((2, 6)), STEP_FLOOR)
    assert found.shape == (2, 3, 3)
    assert (np.linalg.eigvalsh(found) > 0.0).all()


def test_weakest_information_is_the_smallest_eigenvalue():
    matrix = np.array([[5.0, 2.0], [2.0, 1.0]])
    given = np.array([5.0, 2.0, 9.0, 1.0, 9.0, 9.0])
    assert weakest_information(given) == pytest.approx(np.linalg.eigvalsh(matrix)[0])


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.5707, -2.0])
def test_the_weakest_direction_is_forgotten_and_the_others_stay(angle):
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([(c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)])
    given = upper_triangle(turn @ np.diag((5.0, 1e4, 1e5)) @ turn.T)
    kept = forgetting(given)
    left = upper_triangle(kept @ symmetric(given) @ kept)
    np.testing.assert_allclose(symmetric(left), turn @ np.diag((0.0, 1e4, 1e5)) @ turn.T, atol=1e-6)
    edges = edge_information(np.zeros((2, 3)), np.stack((given, left)), CLOSURE_FLOOR)
    assert determines_position(edges).tolist() == [True, False]
