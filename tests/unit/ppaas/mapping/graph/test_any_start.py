"""Graphs of other programs, which start from the odometry, are solved as well as those near their solution."""

import numpy as np
import pytest

from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.graph.solver import GraphSolver, Robust, SolverOptions, solve_any_start
from ppaas.planar_poses import compose, relative

SIDE, ROUNDS = 10, 3
ODOMETRY, CLOSURE = np.array([0.03, 0.03, 0.02]), np.array([0.01, 0.01, 0.01])
BIASES, SEEDS = (0.0, 0.005, 0.01, 0.02), range(3)


def square_walk(bias: float, seed: int) -> PoseGraph:
    """Return three rounds of a square, with the poses of a turned odometry and true closures from round to round."""
    random = np.random.default_rng(seed)
    step, turn = np.array([1.0, 0.0, 0.0]), np.array([1.0, 0.0, np.pi / 2])
    steps = [turn if k % SIDE == SIDE - 1 else step for k in range(4 * SIDE * ROUNDS)]
    graph, truth, pose = PoseGraph(), [np.zeros(3)], np.zeros(3)
    graph.add_node(pose)
    for node, true in enumerate(steps):
        measured = true + random.normal((0.0, 0.0, bias), ODOMETRY)
        truth.append(compose(truth[-1], true))
        pose = compose(pose, measured)
        graph.add_node(pose)
        graph.add_edge(node, node + 1, measured, np.diag(ODOMETRY**-2), EdgeKind.ODOMETRY)
    for first in range(0, len(truth) - 4 * SIDE, 5):
        seen = relative(truth[first], truth[first + 4 * SIDE]) + random.normal(0.0, CLOSURE)
        graph.add_edge(first, first + 4 * SIDE, seen, np.diag(CLOSURE**-2), EdgeKind.CLOSURE)
    return graph


def least_squares(graph: PoseGraph) -> np.ndarray:
    return GraphSolver().solve(graph, SolverOptions(Robust.NONE)).poses


def add_lies(graph: PoseGraph, count: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    for _ in range(count):
        first = int(random.integers(0, graph.node_count - 20))
        second = int(random.integers(first + 10, graph.node_count))
        graph.add_edge(first, second, random.normal(0.0, (0.5, 0.5, 0.3)), np.diag(CLOSURE**-2), EdgeKind.CLOSURE)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("bias", BIASES)
def test_true_closures_of_a_walk_are_trusted(bias: float, seed: int) -> None:
    graph = square_walk(bias, seed)
    right, before = least_squares(graph), graph.poses.copy()
    solution, _ = solve_any_start(graph)
    assert np.abs(solution.poses - right)[:, :2].max() < 1e-3
    assert np.abs(before - right)[:, :2].max() > 1.0
    assert (solution.weights > 0.5).all()
    assert (graph.poses == before).all()


@pytest.mark.parametrize("lies", [2, 10, 20])
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("bias", BIASES[:3])
def test_false_closures_are_told_from_the_true_ones_far_from_the_solution(bias: float, seed: int, lies: int) -> None:
    graph = square_walk(bias, seed)
    true, right = graph.edge_count, least_squares(graph)
    add_lies(graph, lies, seed)
    solution, robust = solve_any_start(graph)
    assert robust is not Robust.NONE
    assert np.abs(solution.poses - right)[:, :2].max() < 0.01
    assert (solution.weights[:true] > 0.5).all() and (solution.weights[true:] < 0.01).all()


def test_least_squares_are_taken_only_while_all_edges_agree() -> None:
    graph = square_walk(0.0, 0)
    assert solve_any_start(graph).robust is Robust.NONE
    graph.move_nodes(least_squares(graph))
    assert solve_any_start(graph).robust is Robust.NONE
    add_lies(graph, 1, 0)
    assert solve_any_start(graph).robust is not Robust.NONE


def test_graph_without_a_loop_is_solved_exactly() -> None:
    graph = square_walk(0.0, 0)
    graph.keep_edges(graph.edges.kinds == EdgeKind.ODOMETRY)
    right = graph.poses.copy()
    graph.move_nodes(np.zeros_like(right))
    solution, robust = solve_any_start(graph)
    assert robust is Robust.NONE
    assert solution.poses[:, :2] == pytest.approx(right[:, :2], abs=1e-6)
