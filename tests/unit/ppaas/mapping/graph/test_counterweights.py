"""Counterweights: the odometry of a graph pulls no node away from refined poses."""

import numpy as np

from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph, balance, measured_odometry
from ppaas.mapping.graph.solver import GraphSolver, Robust, SolverOptions
from ppaas.planar_poses import relative

COUNT = 30


def walk() -> PoseGraph:
    """Return a graph of a walk in circles, the last node of which is joined with the first one."""
    random, graph = np.random.default_rng(3), PoseGraph()
    poses = np.stack((np.cos(np.arange(COUNT)), np.sin(np.arange(COUNT)), np.arange(COUNT) % 6 - 3.0), axis=-1)
    for pose in poses:
        graph.add_node(pose)
    for node in range(1, COUNT):
        step = relative(poses[node - 1], poses[node]) + random.normal(scale=0.01, size=3)
        graph.add_edge(node - 1, node, step, np.diag(random.uniform(1e3, 1e5, 3)), EdgeKind.ODOMETRY)
    graph.add_edge(0, COUNT - 1, relative(poses[0], poses[-1]), 1e4 * np.eye(3), EdgeKind.CLOSURE)
    return graph


def solved(graph: PoseGraph) -> np.ndarray:
    return GraphSolver().solve(graph, SolverOptions(Robust.NONE)).poses


def test_a_solve_stays_at_the_poses_until_a_closure_moves_them():
    graph = walk()
    poses = graph.poses.copy()
    assert np.abs(solved(graph) - poses).max() > 1e-3
    balance(graph, poses)
    np.testing.assert_allclose(solved(graph), poses, atol=1e-6)
    moved = relative(poses[0], poses[15]) + np.array((0.3, 0.0, 0.0))
    graph.add_edge(0, 15, moved, 1e4 * np.eye(3), EdgeKind.CLOSURE)
    assert np.abs(solved(graph) - poses)[15].max() > 0.05


def test_counterweights_are_renewed_and_steps_stay_as_they_were_measured():
    graph = walk()
    steps = graph.edges.take(graph.edges.kinds == EdgeKind.ODOMETRY)
    balance(graph, graph.poses)
    count, other = graph.edge_count, graph.poses + np.random.default_rng(1).normal(scale=0.01, size=(COUNT, 3))
    other[0], closure = graph.poses[0], graph.edges.kinds == EdgeKind.CLOSURE
    graph.renew_measurements(np.flatnonzero(closure), relative(other[:1], other[-1:]))
    balance(graph, other)
    assert graph.edge_count == count == 2 * len(steps.first) + 1
    np.testing.assert_allclose(solved(graph), other, atol=1e-5)
    for kept, before in zip(measured_odometry(graph.edges), steps, strict=True):
        np.testing.assert_array_equal(kept, before)
