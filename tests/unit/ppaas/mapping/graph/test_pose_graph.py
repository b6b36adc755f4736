import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidGraph
from ppaas.geometry import Pose2D
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph, balance, components, measured_odometry
from ppaas.mapping.graph.solver import GraphSolver, Robust, SolverOptions
from ppaas.planar_poses import relative
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


COUNT = 9
ENDS = st.tuples(st.integers(0, COUNT - 1), st.integers(0, COUNT - 1)).filter(lambda ends: ends[0] != ends[1])


def flooded(edges) -> list[int]:
    """Return the components by flooding, numbered by their first nodes."""
    found = list(range(COUNT))
    for _ in range(COUNT):
        for one, other in edges:
            found[one] = found[other] = min(found[one], found[other])
    numbers = sorted(set(found))
    return [numbers.index(each) for each in found]


@given(st.lists(ENDS, max_size=12))
def test_components_are_those_of_flooding(edges):
    graph = PoseGraph()
    for _ in range(COUNT):
        graph.add_node(np.zeros(3))
    for first, second in edges:
        graph.add_edge(first, second, np.zeros(3), np.eye(3), EdgeKind.ODOMETRY)
    assert components(graph).tolist() == flooded(edges)


def test_a_graph_without_nodes_has_no_component():
    assert len(components(PoseGraph())) == 0


NODES = 30


def refined_walk() -> PoseGraph:
    """Return a graph of a walk in circles, the last node of which is joined with the first one."""
    random, graph = np.random.default_rng(3), PoseGraph()
    poses = np.stack(
        (
            np.cos(np.arange(NODES)),
            np.sin(np.arange(NODES)),
            np.arange(NODES) % 6 - 3.0,
        ),
        axis=-1,
    )
    for pose in poses:
        graph.add_node(pose)
    for node in range(1, NODES):
        step = relative(poses[node - 1], poses[node]) + random.normal(scale=0.01, size=3)
        graph.add_edge(node - 1, node, step, np.diag(random.uniform(1e3, 1e5, 3)), EdgeKind.ODOMETRY)
    graph.add_edge(0, NODES - 1, relative(poses[0], poses[-1]), 1e4 * np.eye(3), EdgeKind.CLOSURE)
    return graph


def solved(graph: PoseGraph) -> np.ndarray:
    return GraphSolver().solve(graph, SolverOptions(Robust.NONE)).poses


def test_a_solve_stays_at_the_poses_until_a_closure_moves_them():
    graph = refined_walk()
    poses = graph.poses.copy()
    assert np.abs(solved(graph) - poses).max() > 1e-3
    balance(graph, poses)
    np.testing.assert_allclose(solved(graph), poses, atol=1e-6)
    moved = relative(poses[0], poses[15]) + np.array((0.3, 0.0, 0.0))
    graph.add_edge(0, 15, moved, 1e4 * np.eye(3), EdgeKind.CLOSURE)
    assert np.abs(solved(graph) - poses)[15].max() > 0.05


def test_counterweights_are_renewed_and_steps_stay_as_they_were_measured():
    graph = refined_walk()
    steps = graph.edges.take(graph.edges.kinds == EdgeKind.ODOMETRY)
    balance(graph, graph.poses)
    count, other = (
        graph.edge_count,
        graph.poses + np.random.default_rng(1).normal(scale=0.01, size=(NODES, 3)),
    )
    other[0], closure = graph.poses[0], graph.edges.kinds == EdgeKind.CLOSURE
    graph.renew_measurements(np.flatnonzero(closure), relative(other[:1], other[-1:]))
    balance(graph, other)
    assert graph.edge_count == count == 2 * len(steps.first) + 1
    np.testing.assert_allclose(solved(graph), other, atol=1e-5)
    for kept, before in zip(measured_odometry(graph.edges), steps, strict=True):
        np.testing.assert_array_equal(kept, before)
