import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.mapping.graph.kernels import elimination_tree as kernels
from tests.reference.mapping import pose_graph as twin


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
