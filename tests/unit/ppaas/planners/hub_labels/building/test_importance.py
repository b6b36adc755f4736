"""Corners are ordered by how many shortest paths lead through them."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from ppaas.planners.hub_labels.building.contraction import Contraction
from ppaas.planners.hub_labels.building.graph import build_corner_graph, build_corner_map
from ppaas.planners.hub_labels.building.importance import RankedEdges, edges_of, grow_trees, order_core
from ppaas.planners.hub_labels.building.kernels.coverage import GROUPS, cover
from ppaas.planners.hub_labels.kernels.scan import STRAIGHT
from ppaas.planners.watch import proceed
from tests.reference.planners import hub_labels as twin
from tests.support.budget import examples
from tests.unit.ppaas.planners.hub_labels.kernels.test_scan import maps

PILLARS = np.ones((6, 6), bool)
PILLARS[np.ix_((1, 4), (1, 4))] = False


def edges_in(free) -> RankedEdges:
    graph = build_corner_graph(build_corner_map(free, threads=1, check=proceed), threads=1, check=proceed)
    nodes = np.arange(len(graph.starts) - 1, dtype=np.int32)
    return edges_of(Contraction(graph, most_edge_visits=-1).run(check=proceed), nodes, nodes)


@given(maps(6), st.integers(1, 40))
@example(PILLARS, 1)
@settings(max_examples=examples(20))
def test_order_covers_the_most_uncounted_paths_first(free, budget):
    edges = edges_in(free)
    nodes = len(edges.starts) - 1
    if nodes == 0:
        return
    roots = np.random.default_rng(1).permutation(nodes).astype(np.int32)
    trees = grow_trees(edges, roots, threads=1, check=proceed)
    sizes = trees.sizes.copy()
    totals = np.column_stack([sizes[group::GROUPS].sum(axis=0, dtype=np.int32) for group in range(GROUPS)])
    order, state = np.empty(nodes, np.int32), np.zeros(2, np.int64)
    while not cover(trees.parents, sizes, trees.firsts, trees.nexts, totals, order, state, budget):
        pass
    assert order[: state[0]].tolist() == twin.most_covering(trees.parents.tolist(), GROUPS)


@pytest.mark.parametrize("blocked", [0.005, 0.05])
def test_order_is_a_permutation_independent_of_threads(blocked):
    edges = edges_in(np.random.default_rng(3).random((200, 200)) >= blocked)
    one, two = (order_core(edges, threads=threads, check=proceed) for threads in (1, 2))
    np.testing.assert_array_equal(one, two)
    np.testing.assert_array_equal(np.sort(one), np.arange(len(edges.starts) - 1))


def test_tree_prefers_the_shortest_last_edge_among_equal_paths():
    pairs = [(0, 1, 1), (0, 2, 3), (1, 3, 4), (2, 3, 2), (0, 3, 5)]
    both = sorted(pairs + [(b, a, length) for a, b, length in pairs])
    starts = np.searchsorted([a for a, _, _ in both], np.arange(5))
    to, lengths = np.array([(b, length) for _, b, length in both], np.int32).T.copy()
    edges = RankedEdges(starts, to, STRAIGHT * lengths, np.arange(len(to), dtype=np.int32))
    trees = grow_trees(edges, np.zeros(1, np.int32), threads=1, check=proceed)
    assert trees.parents.tolist() == [[-1, 0, 0, 2]]
