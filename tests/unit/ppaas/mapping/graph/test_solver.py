"""Pose graphs are solved, and those of other programs from the odometry as well as from near their solution."""

import numpy as np
import pytest
import scipy.optimize

from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.graph.solver import GraphSolver, Robust, SolverOptions, solve_any_start
from ppaas.planar_poses import compose, relative
from tests.reference.mapping import pose_graph as twin
from tests.support.world.pose_graphs import walk


def distances(poses, truth):
    return np.hypot(*(poses - truth)[:, :2].T)


def test_least_squares_agree_with_scipy():
    graph, _, _ = walk(25, 15)
    solution = GraphSolver().solve(graph, SolverOptions(Robust.NONE, tolerance=1e-9))
    start, fixed = graph.poses[1:].ravel(), graph.poses[:1]
    weights = np.ones(graph.edge_count)
    expected = scipy.optimize.least_squares(twin.residuals, start, args=(graph.edges, fixed, weights), xtol=1e-12)
    assert solution.poses[1:, :2] == pytest.approx(expected.x.reshape(-1, 3)[:, :2], abs=1e-5)
    assert solution.chi2.sum() == pytest.approx(2 * expected.cost, rel=1e-6)
    assert (solution.poses[0] == graph.poses[0]).all()


@pytest.mark.parametrize("robust", Robust)
def test_drift_of_a_long_walk_is_removed(robust):
    graph, truth, _ = walk(1500, 2500)
    before = graph.poses.copy()
    solution = GraphSolver().solve(graph, SolverOptions(robust))
    assert solution.converged
    assert distances(before, truth).max() > 0.8
    assert distances(solution.poses, truth).mean() < 0.06
    assert (solution.weights > 0.5).all()
    assert (graph.poses == before).all()


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("robust", [Robust.SCALING, Robust.GRADUATED])
def test_false_closures_lose_their_weight(robust, seed):
    graph, truth, false = walk(1500, 2500, false=20, seed=seed)
    solution = GraphSolver().solve(graph, SolverOptions(robust))
    wrong = np.hypot(*(truth[graph.edges.first[-false:]] - truth[graph.edges.second[-false:]])[:, :2].T) > 2.0
    assert (solution.weights[-false:][wrong] < 0.1).all()
    assert (solution.weights[:-false] > 0.1).mean() > 0.999
    assert distances(solution.poses, truth).mean() < 0.1


def test_graduated_solve_closes_a_loop_that_scaling_gives_up():
    # A loop of 400 m whose odometry turns too little, and one group of closures at its end.
    graph, step = PoseGraph(), np.array([1.0, 0.0, 2 * np.pi / 400])
    truth, pose = [np.zeros(3)], np.zeros(3)
    for _ in range(409):
        truth.append(compose(truth[-1], step))
    graph.add_node(pose)
    for k in range(409):
        drifted = step - (0.0, 0.0, 0.003)
        pose = compose(pose, drifted)
        graph.add_node(pose)
        graph.add_edge(k, k + 1, drifted, np.diag([400.0, 400.0, 1e5]), EdgeKind.ODOMETRY)
    for k in range(10):
        graph.add_edge(k, 400 + k, np.zeros(3), np.diag([2500.0, 2500.0, 4e4]), EdgeKind.CLOSURE)
    scaled = GraphSolver().solve(graph, SolverOptions(Robust.SCALING))
    assert (scaled.weights[-10:] < 0.1).all()
    solution = GraphSolver().solve(graph, SolverOptions(Robust.GRADUATED))
    assert (solution.weights == 1.0).all()
    assert distances(solution.poses, np.array(truth)).max() < 1.5
    assert distances(graph.poses, np.array(truth)).max() > 60.0


def test_parts_that_no_edge_connects_stay_where_they_start():
    graph, _, _ = walk(40, 10)
    offset, count = np.array([100.0, 0.0, 1.0]), graph.node_count
    for pose in compose(offset, graph.poses.copy()):
        graph.add_node(pose)
    for first, second, measured, information, kind in zip(*graph.edges.take(np.arange(graph.edge_count)), strict=True):
        graph.add_edge(first + count, second + count, measured, information, EdgeKind(kind))
    solution = GraphSolver().solve(graph, SolverOptions(Robust.NONE, tolerance=1e-8))
    assert solution.poses[count:, :2] == pytest.approx(compose(offset, solution.poses[:count])[:, :2], abs=1e-6)


def test_solver_follows_a_growing_graph():
    graph, truth, _ = walk(300, 300)
    part, solver = PoseGraph(), GraphSolver()
    for pose in graph.poses[:200]:
        part.add_node(pose)
    early = graph.edges.take(np.maximum(graph.edges.first, graph.edges.second) < 200)
    for first, second, measured, information, kind in zip(*early, strict=True):
        part.add_edge(first, second, measured, information, EdgeKind(kind))
    assert distances(solver.solve(part).poses, truth[:200]).mean() < 0.1
    again = solver.solve(graph)
    assert (again.poses == GraphSolver().solve(graph).poses).all()


def test_solve_from_the_solution_takes_one_step():
    graph, _, _ = walk(300, 300)
    solver = GraphSolver()
    graph.move_nodes(solver.solve(graph).poses)
    again = solver.solve(graph)
    assert again.iterations == 1 and again.converged


def test_solve_without_enough_steps_reports_it():
    graph, _, _ = walk(300, 300)
    solution = GraphSolver().solve(graph, SolverOptions(Robust.NONE, iterations=1))
    assert solution.iterations <= 3 and not solution.converged


def test_information_that_is_not_positive_definite_does_not_converge():
    graph, _, _ = walk(10, 0)
    graph.add_edge(0, 9, (0.0, 0.0, 0.0), -1e9 * np.eye(3), EdgeKind.CLOSURE)
    solution = GraphSolver().solve(graph, SolverOptions(Robust.NONE))
    assert not solution.converged
    assert np.isfinite(solution.poses).all()


def test_empty_graph_is_solved():
    solution = GraphSolver().solve(PoseGraph())
    assert solution.poses.shape == (0, 3) and solution.converged


def test_graph_of_one_node_is_solved():
    graph = PoseGraph()
    graph.add_node((1.0, 2.0, 3.0))
    assert GraphSolver().solve(graph, SolverOptions(Robust.GRADUATED)).poses.tolist() == [[1.0, 2.0, 3.0]]


def test_fixed_nodes_stay_and_hold_their_part():
    graph = PoseGraph()
    for x in (0.0, 1.0, 2.0, 3.3, 7.0, 7.5):
        graph.add_node((x, 0.0, 0.0))
    for first, second in ((0, 1), (1, 2), (2, 3), (4, 5)):
        graph.add_edge(first, second, (1.0, 0.0, 0.0), np.diag([100.0, 100.0, 100.0]), EdgeKind.ODOMETRY)
    both = GraphSolver((0, 3)).solve(graph, SolverOptions(Robust.NONE))
    assert both.poses[:, 0] == pytest.approx([0.0, 1.1, 2.2, 3.3, 7.0, 8.0])
    last = GraphSolver((3,)).solve(graph, SolverOptions(Robust.NONE))
    assert last.poses[:, 0] == pytest.approx([0.3, 1.3, 2.3, 3.3, 7.0, 8.0])


@pytest.mark.parametrize("seed", range(4))
def test_least_squares_with_fixed_nodes_agree_with_scipy(seed):
    graph, _, _ = walk(25, 15, seed=seed)
    random = np.random.default_rng(seed)
    fixed = tuple(np.sort(random.choice(25, 4, replace=False)).tolist())
    free = np.setdiff1d(np.arange(25), fixed)
    solution = GraphSolver(fixed).solve(graph, SolverOptions(Robust.NONE, tolerance=1e-9))

    def lengths(numbers):
        poses = graph.poses.copy()
        poses[free] = numbers.reshape(-1, 3)
        return twin.residuals(poses[1:].ravel(), graph.edges, poses[:1], np.ones(graph.edge_count))

    expected = scipy.optimize.least_squares(lengths, graph.poses[free].ravel(), xtol=1e-12)
    assert (solution.poses[list(fixed), :2] == graph.poses[list(fixed), :2]).all()
    assert solution.chi2.sum() == pytest.approx(2 * expected.cost, rel=1e-6)
    assert solution.poses[free, :2] == pytest.approx(expected.x.reshape(-1, 3)[:, :2], abs=1e-5)


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
