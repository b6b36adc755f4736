import numpy as np
import pytest

from ppaas.errors import InvalidGraph
from ppaas.geometry import Pose2D
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from tests.support.world.pose_graphs import walk


def test_nodes_and_edges_are_stored_in_order():
    graph = PoseGraph()
    for k in range(200):
        assert graph.add_node(Pose2D(k, 2.0 * k, 0.1)) == k
    for k in range(199):
        assert graph.add_edge(k, k + 1, (1.0, 2.0, 0.0), np.eye(3) * (k + 1), EdgeKind.ODOMETRY) == k
    assert graph.add_edge(150, 3, (0.0, 0.0, 3.0), np.eye(3), EdgeKind.CLOSURE) == 199
    assert (graph.node_count, graph.edge_count) == (200, 200)
    assert graph.poses[:, 1].tolist() == [2.0 * k for k in range(200)]
    edges = graph.edges
    assert edges.first.tolist() == [*range(199), 150] and edges.second.tolist() == [*range(1, 200), 3]
    assert edges.information[:199, 2, 2].tolist() == list(range(1, 200))
    assert edges.kinds.tolist() == [0] * 199 + [1]


def test_empty_graph_has_empty_arrays():
    graph = PoseGraph()
    assert graph.poses.shape == (0, 3)
    assert [array.shape for array in graph.edges] == [(0,), (0,), (0, 3), (0, 3, 3), (0,)]


def test_views_cannot_be_written():
    graph, _, _ = walk(3, 0)
    with pytest.raises(ValueError, match="read-only"):
        graph.poses[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        graph.edges.measurements[0] = 1.0


def test_nodes_can_be_moved():
    graph, truth, _ = walk(5, 0)
    graph.move_nodes(truth)
    assert (graph.poses == truth).all()


def test_edges_can_be_removed():
    graph, _, _ = walk(70, 20)
    before = graph.edges.take(np.arange(graph.edge_count))
    keep = np.arange(graph.edge_count) % 3 > 0
    graph.keep_edges(keep)
    assert all((a == b).all() for a, b in zip(graph.edges, before.take(keep), strict=True))
    graph.add_edge(0, 9, (1.0, 0.0, 0.0), np.eye(3), EdgeKind.CLOSURE)
    assert graph.edges.second[-1] == 9 and graph.edge_count == keep.sum() + 1


@pytest.mark.parametrize("pose", [(0.0, 0.0), (0.0, np.nan, 0.0), (np.inf, 0.0, 0.0)])
def test_pose_that_is_not_three_finite_numbers_is_refused(pose):
    with pytest.raises(InvalidGraph, match="three finite numbers"):
        PoseGraph().add_node(pose)


@pytest.mark.parametrize(
    ("first", "second", "measurement", "information", "text"),
    [
        (0, 3, (0, 0, 0), np.eye(3), "the graph has 3 nodes"),
        (-1, 0, (0, 0, 0), np.eye(3), "edge names node -1"),
        (1, 1, (0, 0, 0), np.eye(3), "to itself"),
        (0, 1, (0, 0, np.nan), np.eye(3), "not finite"),
        (0, 1, (0, 0, 0), np.full((3, 3), np.inf), "not finite"),
        (0, 1, (0, 0), np.eye(3), "shape"),
        (0, 1, (0, 0, 0), np.eye(2), "shape"),
    ],
)
def test_invalid_edge_is_refused(first, second, measurement, information, text):
    graph, _, _ = walk(3, 0)
    with pytest.raises(InvalidGraph, match=text):
        graph.add_edge(first, second, measurement, information, EdgeKind.CLOSURE)
    assert graph.edge_count == 2
