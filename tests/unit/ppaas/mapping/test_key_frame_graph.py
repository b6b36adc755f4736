"""Key frames as nodes of a pose graph."""

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.key_frame_graph import STEP_FLOOR, append_key_frame, edge_information
from ppaas.mapping.key_frames import KeyFrames
from ppaas.planar_poses import compose
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
