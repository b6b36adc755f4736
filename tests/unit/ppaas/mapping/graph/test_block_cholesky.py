import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.errors import InvalidGraph
from ppaas.mapping.graph import block_cholesky
from ppaas.mapping.graph.block_cholesky import BlockCholesky, plan_elimination
from ppaas.mapping.graph.kernels import elimination_tree as kernels
from ppaas.mapping.graph.kernels.minimum_degree import minimum_degree
from ppaas.mapping.graph.normal_equations import JointSystem, LinearisedPairs
from ppaas.mapping.graph.solver import GraphSolver, Robust, SolverOptions
from ppaas.planar_poses import relative, wrap_angles
from tests.reference.mapping import pose_graph as twin
from tests.support.world.pose_graphs import walk


def random_matrix(count, pairs, seed):
    """Return pairs and blocks of a random positive definite matrix."""
    random = np.random.default_rng(seed)
    ends = np.sort(random.integers(0, count, (pairs, 2)), axis=1)
    keys = np.unique(ends[ends[:, 0] < ends[:, 1]] @ [count, 1])
    first, second = keys // count, keys % count
    off_diagonal = random.normal(size=(len(keys), 3, 3))
    diagonal = random.normal(size=(count, 3, 3)) * 0.1
    diagonal = diagonal @ np.swapaxes(diagonal, 1, 2) + 0.1 * np.eye(3)
    for block, i, j in zip(off_diagonal, first, second, strict=True):
        diagonal[i] += np.abs(block).sum() * np.eye(3)
        diagonal[j] += np.abs(block).sum() * np.eye(3)
    return first, second, diagonal, off_diagonal


def agree(found, expected):
    """Return whether arrays agree as by `pytest.approx`, which compares element by element."""
    return (np.abs(found - expected) <= np.maximum(1e-9 * np.abs(expected), 1e-12)).all()


@settings(deadline=None)
@given(st.integers(1, 60), st.integers(0, 150), st.integers(0, 1000))
def test_solution_agrees_with_a_dense_solver(count, pairs, seed):
    first, second, diagonal, off_diagonal = random_matrix(count, pairs, seed)
    random = np.random.default_rng(seed)
    damping, right = random.uniform(0.0, 1.0, (count, 3)), random.normal(size=(count, 3, 2))
    factor = BlockCholesky(count, first, second)
    assert factor.factorise(diagonal, off_diagonal, damping)
    matrix = twin.dense(diagonal, off_diagonal, first, second) + np.diag(damping.ravel())
    expected = np.linalg.solve(matrix, right.reshape(3 * count, 2))
    assert agree(factor.solve(right).reshape(3 * count, 2), expected)
    assert agree(factor.solve(right[:, :, 0]).ravel(), expected[:, 0])


def test_factor_can_be_computed_again_for_other_numbers():
    first, second, diagonal, off_diagonal = random_matrix(40, 80, 1)
    factor, right = BlockCholesky(40, first, second), np.ones((40, 3))
    assert factor.factorise(diagonal, off_diagonal, np.zeros((40, 3)))
    once = factor.solve(right)
    assert factor.factorise(2.0 * diagonal, 2.0 * off_diagonal, np.zeros((40, 3)))
    assert factor.solve(right) == pytest.approx(once / 2.0)


def test_matrix_that_is_not_positive_definite_is_refused():
    first, second, diagonal, off_diagonal = random_matrix(40, 80, 1)
    diagonal[17, 1, 1] = -1.0
    factor = BlockCholesky(40, first, second)
    assert not factor.factorise(diagonal, off_diagonal, np.zeros((40, 3)))
    diagonal[17, 1, 1] = np.nan
    assert not factor.factorise(diagonal, off_diagonal, np.zeros((40, 3)))


def test_matrix_without_rows_has_an_empty_solution():
    none = np.empty(0, np.int64)
    factor = BlockCholesky(0, none, none)
    assert factor.factorise(np.empty((0, 3, 3)), np.empty((0, 3, 3)), np.empty((0, 3)))
    assert factor.solve(np.empty((0, 3))).shape == (0, 3)


def grid_pairs(side):
    nodes = np.arange(side * side).reshape(side, side)
    across = np.column_stack((nodes[:, :-1].ravel(), nodes[:, 1:].ravel()))
    down = np.column_stack((nodes[:-1].ravel(), nodes[1:].ravel()))
    return np.vstack((across, down)).T


@pytest.fixture(params=[(0, 0.0), (4, 0.25), (1000, 1.0)], ids=["exact", "relaxed", "dense"])
def plan(request, monkeypatch):
    monkeypatch.setattr(block_cholesky, "SMALL_FRONT", request.param[0])
    monkeypatch.setattr(block_cholesky, "ZERO_SHARE", request.param[1])
    return plan_elimination(144, *grid_pairs(12))


def test_fronts_cover_all_columns_and_hold_all_entries(plan):
    assert sorted(plan.labels) == list(range(144))
    assert plan.starts[0] == 0 and plan.starts[-1] == 144
    for s, begin in enumerate(plan.starts[:-1]):
        rows = plan.rows[plan.row_starts[s] : plan.row_starts[s + 1]]
        columns = np.arange(begin, plan.starts[s + 1])
        assert (rows[: len(columns)] == columns).all() and (np.diff(rows) > 0).all()
        for column in columns:
            assert np.isin(plan.entry_rows[plan.entry_starts[column] : plan.entry_starts[column + 1]], rows).all()


def test_rows_below_a_front_are_in_its_parents(plan):
    fronts = [set(plan.rows[plan.row_starts[s] : plan.row_starts[s + 1]]) for s in range(len(plan.children))]
    owner = np.repeat(np.arange(len(plan.children)), np.diff(plan.starts))
    children = np.zeros_like(plan.children)
    for s, rows in enumerate(fronts):
        below = {row for row in rows if row >= plan.starts[s + 1]}
        if below:
            parent = owner[min(below)]
            children[parent] += 1
            assert below <= fronts[parent]
    assert (children == plan.children).all()


def test_order_of_a_grid_has_little_fill():
    side = 60
    plan = plan_elimination(side * side, *grid_pairs(side))
    band = side * side * side * 9  # numbers in the factor of the order by rows
    assert plan.size < 0.6 * band


def structure_of(count, ends, seed):
    """Return an order of elimination at random, and the structure that it makes."""
    order = np.random.default_rng(seed).permutation(count)
    members = twin.eliminated(count, {(a, b) for a, b in ends if a != b}, order)
    starts = np.concatenate(([0], np.cumsum([len(found) for found in members]))).astype(np.int64)
    flat = np.array([node for found in members for node in sorted(found)], np.int64)
    return order, starts, flat, members


graphs = st.integers(1, 14).flatmap(
    lambda count: st.tuples(
        st.just(count),
        st.sets(st.tuples(st.integers(0, count - 1), st.integers(0, count - 1)), max_size=25),
        st.integers(0, 1000),
    )
)


@given(graphs)
def test_parent_is_the_first_member_to_be_eliminated(graph):
    order, starts, flat, members = structure_of(*graph)
    steps = {node: step for step, node in enumerate(order)}
    expected = [min((steps[node] for node in found), default=-1) for found in members]
    assert kernels.elimination_tree(order, starts, flat).tolist() == expected


@given(graphs)
def test_postorder_visits_each_subtree_without_a_break(graph):
    order, starts, flat, _ = structure_of(*graph)
    parents = kernels.elimination_tree(order, starts, flat)
    visited = kernels.postorder(parents, np.diff(starts) + 1)
    assert sorted(visited) == list(range(len(order)))
    place = np.argsort(visited)
    sizes = np.ones(len(order), np.int64)
    for step, parent in enumerate(parents):
        if parent >= 0:
            sizes[parent] += sizes[step]
    for step in range(len(order)):
        below = {other for other in range(len(order)) if place[step] - sizes[step] < place[other] <= place[step]}
        assert all(other == step or parents[other] in below for other in below)


def test_child_with_the_longest_column_comes_last():
    assert kernels.postorder(np.array([3, 3, 3, -1]), np.array([2, 4, 3, 1])).tolist()[2:] == [1, 3]


def test_columns_of_one_structure_become_one_supernode():
    parents, counts = np.array([1, 2, 4, 4, 5, -1]), np.array([3, 2, 2, 3, 2, 1])
    starts, heights = kernels.supernodes(parents, counts, 0, 0.0)
    assert starts.tolist() == [0, 2, 3, 6]
    assert heights.tolist() == [3, 2, 3]


pairs_of_nodes = st.integers(1, 14).flatmap(
    lambda count: st.tuples(
        st.just(count), st.sets(st.tuples(st.integers(0, count - 1), st.integers(0, count - 1)), max_size=40)
    )
)


def neighbour_lists(count, pairs):
    lists = [sorted({b for a, b in pairs if a == i} | {a for a, b in pairs if b == i}) for i in range(count)]
    starts = np.concatenate(([0], np.cumsum([len(found) for found in lists]))).astype(np.int64)
    return starts, np.array([node for found in lists for node in found], np.int64)


@given(pairs_of_nodes)
def test_structure_is_that_of_elimination_in_the_order(graph):
    count, ends = graph
    pairs = {(min(a, b), max(a, b)) for a, b in ends if a != b}
    order, starts, members = minimum_degree(*neighbour_lists(count, pairs))
    assert sorted(order) == list(range(count))
    found = [set(members[starts[k] : starts[k + 1]]) for k in range(count)]
    assert found == twin.eliminated(count, pairs, order)
    assert all(len(found[k]) == starts[k + 1] - starts[k] for k in range(count))


def test_tree_has_no_fill():
    pairs = {(node // 2, node) for node in range(1, 64)}
    _, starts, _ = minimum_degree(*neighbour_lists(64, pairs))
    assert starts[-1] == len(pairs)


def test_ring_has_the_least_fill():
    count = 50
    pairs = {(k, (k + 1) % count) for k in range(count)}
    _, starts, _ = minimum_degree(*neighbour_lists(count, pairs))
    assert starts[-1] == count + count - 3


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
