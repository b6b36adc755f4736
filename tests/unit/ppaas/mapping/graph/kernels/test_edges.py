import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.mapping.graph.kernels import edges as kernels
from tests.reference.mapping import pose_graph as twin
from tests.support.world.pose_graphs import walk

seeds = st.integers(0, 1000)


@given(seeds)
def test_errors_agree_with_single_poses(seed):
    graph, _, _ = walk(30, 20, false=3, seed=seed)
    edges, poses = graph.edges, graph.poses.copy()
    errors, chi2 = np.empty((len(edges.first), 3)), np.empty(len(edges.first))
    kernels.edge_errors(poses, *edges[:4], errors, chi2)
    for k, (i, j) in enumerate(zip(edges.first, edges.second, strict=True)):
        expected = twin.error_of(poses, i, j, edges.measurements[k])
        assert errors[k] == pytest.approx(expected, abs=1e-9)
        assert chi2[k] == pytest.approx(expected @ edges.information[k] @ expected)


@given(seeds, st.booleans())
def test_normal_equations_agree_with_numerical_derivatives(seed, swap):
    graph, _, _ = walk(12, 8, false=3, seed=seed)
    edges, poses, count = graph.edges, graph.poses.copy(), graph.node_count
    random = np.random.default_rng(seed)
    weights, gradients = random.uniform(0.0, 1.0, len(edges.first)), random.normal(size=(len(edges.first), 3))
    lower, upper = np.minimum(edges.first, edges.second), np.maximum(edges.first, edges.second)
    keys, slots = np.unique(lower * count + upper, return_inverse=True)
    rows = np.arange(count)[::-1].copy() if swap else np.arange(count)
    slots = np.where(rows[edges.second] > rows[edges.first], slots, ~slots)
    blocks = np.zeros((count, 3, 3)), np.zeros((len(keys), 3, 3)), np.zeros((count, 3))
    ends = edges.first, edges.second
    kernels.add_edges(poses, *ends, edges.information, gradients, weights, rows, slots, *blocks)
    matrix, right = twin.normal_equations(poses, edges, weights, gradients)
    ends_of_pairs = rows[keys // count], rows[keys % count]
    found = twin.dense(blocks[0], blocks[1], np.minimum(*ends_of_pairs), np.maximum(*ends_of_pairs))
    place = (3 * rows[:, None] + np.arange(3)).ravel()
    assert np.allclose(found[np.ix_(place, place)], matrix, rtol=1e-6, atol=1e-3)
    assert np.allclose(blocks[2].ravel()[place], right, rtol=1e-6, atol=1e-3)


def test_fixed_nodes_have_no_rows():
    graph, _, _ = walk(3, 0)
    edges, poses = graph.edges, graph.poses.copy()
    blocks = np.zeros((1, 3, 3)), np.zeros((0, 3, 3)), np.zeros((1, 3))
    rows, slots = np.array([-1, 0, -1]), np.zeros(2, np.int64)
    gradients = np.ones((2, 3))
    kernels.add_edges(poses, *edges[:2], edges.information, gradients, np.ones(2), rows, slots, *blocks)
    matrix, right = twin.normal_equations(poses, edges, np.ones(2), gradients)
    assert np.allclose(blocks[0][0], matrix[3:6, 3:6], rtol=1e-6, atol=1e-3)
    assert np.allclose(blocks[2][0], right[3:6], rtol=1e-6, atol=1e-3)


def test_connected_parts_are_named_by_their_first_node():
    first, second = np.array([4, 1, 6]), np.array([2, 4, 5])
    assert kernels.connected_parts(8, first, second).tolist() == [0, 1, 1, 3, 1, 5, 5, 7]
