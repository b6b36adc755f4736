import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.mapping.graph.kernels.minimum_degree import minimum_degree
from tests.reference.mapping import pose_graph as twin

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
