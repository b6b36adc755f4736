import numpy as np
import pytest

from ppaas.errors import InvalidGraph
from ppaas.mapping.graph.normal_equations import JointSystem, LinearisedPairs
from ppaas.mapping.graph.solver import GraphSolver, Robust, SolverOptions
from ppaas.planar_poses import relative, wrap_angles
from tests.support.world.pose_graphs import walk


def linearised(graph, poses):
    """Return the edges of a graph as linearised pairs."""
    edges = graph.edges
    errors = relative(poses[edges.first], poses[edges.second]) - edges.measurements
    errors[:, 2] = wrap_angles(errors[:, 2])
    gradients = np.einsum("mij,mj->mi", edges.information, errors)
    return LinearisedPairs(edges.first, edges.second, edges.information, gradients)


def test_steps_lead_to_the_solution_of_the_graph():
    graph, _, _ = walk(100, 100)
    expected = GraphSolver().solve(graph, SolverOptions(Robust.NONE, tolerance=1e-9)).poses
    poses, system = graph.poses.copy(), JointSystem()
    for _ in range(15):
        poses += system.step(poses, linearised(graph, poses))
    assert poses[:, :2] == pytest.approx(expected[:, :2], abs=1e-6)


def test_repeated_pairs_add_up():
    graph, _, _ = walk(30, 20)
    poses = graph.poses.copy()
    once = linearised(graph, poses)
    twice = LinearisedPairs(*(np.concatenate((array, array)) for array in once))
    expected = JointSystem().step(poses, once, damping=1e-9)
    assert JointSystem().step(poses, twice, damping=2e-9) == pytest.approx(expected)


def test_damping_shortens_a_step():
    graph, _, _ = walk(30, 20)
    poses = graph.poses.copy()
    pairs = linearised(graph, poses)
    assert np.abs(JointSystem().step(poses, pairs, 1e6)).max() < np.abs(JointSystem().step(poses, pairs)).max()


def test_pairs_that_are_not_positive_definite_are_refused():
    graph, _, _ = walk(30, 20)
    poses = graph.poses.copy()
    pairs = linearised(graph, poses)
    with pytest.raises(InvalidGraph, match="not positive definite"):
        JointSystem().step(poses, pairs._replace(hessians=-pairs.hessians))
