import numpy as np
import pytest

from ppaas.errors import InvalidGraph
from ppaas.mapping.graph.marginals import Marginals
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.graph.solver import GraphSolver, Robust, SolverOptions
from tests.reference.mapping import pose_graph as twin
from tests.support.world.pose_graphs import walk


@pytest.mark.parametrize("node", [0, 7, 39])
def test_covariances_agree_with_those_of_dense_equations_that_fix_the_node(node):
    graph, _, _ = walk(40, 30)
    poses = graph.poses.copy()
    found = Marginals(graph).relative_to(node)
    matrix, _ = twin.normal_equations(poses, graph.edges, np.ones(graph.edge_count))
    free = np.delete(np.arange(120), range(3 * node, 3 * node + 3))
    inverse = np.zeros((120, 120))
    inverse[np.ix_(free, free)] = np.linalg.inv(matrix[np.ix_(free, free)])
    for other in range(40):
        if other != node:
            _, by_other = twin.derivatives(poses, node, other)
            block = inverse[3 * other : 3 * other + 3, 3 * other : 3 * other + 3]
            assert found[other] == pytest.approx(by_other @ block @ by_other.T, rel=1e-4, abs=1e-9)
    assert (found[node] == 0.0).all()


def test_closures_make_nodes_more_certain():
    graph, _, _ = walk(300, 300)
    solution = GraphSolver().solve(graph)
    closed = Marginals(graph, solution).relative_to(0)
    graph.keep_edges(graph.edges.kinds == EdgeKind.ODOMETRY)
    assert np.trace(closed[299]) < 0.2 * np.trace(Marginals(graph).relative_to(0)[299])


def test_edges_without_weight_do_not_count():
    graph, _, false = walk(300, 300, false=10)
    solution = GraphSolver().solve(graph, SolverOptions(Robust.GRADUATED))
    with_false = Marginals(graph, solution).relative_to(0)
    graph.keep_edges(np.arange(graph.edge_count) < graph.edge_count - false)
    graph.move_nodes(solution.poses)
    assert np.trace(with_false, axis1=1, axis2=2)[1:] == pytest.approx(
        np.trace(Marginals(graph).relative_to(0), axis1=1, axis2=2)[1:], rel=0.05
    )


def test_node_of_another_part_is_anywhere():
    graph, _, _ = walk(10, 0)
    graph.add_node((0.0, 0.0, 0.0))
    found = Marginals(graph).relative_to(3)
    assert (np.diag(found[10]) == np.inf).all() and np.isfinite(found[:10]).all()


def test_information_that_is_not_positive_definite_is_refused():
    graph = PoseGraph()
    for _ in range(2):
        graph.add_node((0.0, 0.0, 0.0))
    graph.add_edge(0, 1, (0.0, 0.0, 0.0), -np.eye(3), EdgeKind.ODOMETRY)
    with pytest.raises(InvalidGraph, match="not positive definite"):
        Marginals(graph)
