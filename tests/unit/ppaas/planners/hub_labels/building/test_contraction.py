"""A contracted graph keeps all distances, and corners are ordered by how many shortest paths lead through them."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from ppaas.planners.hub_labels.building import contraction as contractions
from ppaas.planners.hub_labels.building.contraction import ANY_COST, Contraction
from ppaas.planners.hub_labels.building.graph import build_corner_graph, build_corner_map
from ppaas.planners.hub_labels.building.importance import RankedEdges, grow_trees, order_core
from ppaas.planners.hub_labels.building.importance import edges_of as edges_of_importance
from ppaas.planners.hub_labels.building.kernels.contraction import LEFT, LENGTH, RIGHT, TO
from ppaas.planners.hub_labels.building.kernels.coverage import GROUPS, cover
from ppaas.planners.hub_labels.kernels.scan import STRAIGHT
from ppaas.planners.watch import proceed
from tests.reference.planners import hub_labels as twin
from tests.support.budget import examples
from tests.unit.ppaas.planners.hub_labels.kernels.test_scan import maps


def graph_of(free):
    return build_corner_graph(build_corner_map(free, threads=1, check=proceed), threads=1, check=proceed)


def contracted(free, core, costs=ANY_COST, threads=1):
    """Return a contracted graph, and the cells of its nodes."""
    graph = graph_of(free)
    result = Contraction(graph, costs, threads=threads).run(core, check=proceed)
    return result, [(int(row) - 1, int(column) - 1) for row, column in graph.positions]


def edges_of(graph, node):
    edge = graph.head[node]
    while edge >= 0:
        yield edge
        edge = graph.after[edge]


def lengths_upwards(graph, source):
    """Return the distances of all nodes that a node reaches upwards, as integers."""
    lengths, queue = {source: 0}, [source]
    while queue:
        node = queue.pop()
        for edge in edges_of(graph, node):
            to, further = int(graph.edges[edge, TO]), lengths[node] + int(graph.edges[edge, LENGTH])
            if further < lengths.get(to, math.inf):
                lengths[to] = further
                queue.append(to)
    return lengths


def assert_lengths_are_kept(free, graph, cells):
    reached = [lengths_upwards(graph, node) for node in range(len(cells))]
    for start, own in enumerate(reached[::3]):
        lengths = twin.lengths_from(free, cells[3 * start])
        for goal, other in enumerate(reached):
            over = min((own[node] + other[node] for node in own.keys() & other.keys()), default=math.inf)
            assert over / STRAIGHT == pytest.approx(lengths[cells[goal]])


@given(free=maps(14), core=st.integers(0, 8), settle=st.sampled_from([1, 300]), neighbours=st.sampled_from([2, 16]))
def test_contraction_keeps_all_distances(free, core, settle, neighbours):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(contractions, "SETTLED", settle)
        patch.setattr(contractions, "SETTLED_FOR_A_COST", settle)
        patch.setattr(contractions, "MOST_NEIGHBOURS", neighbours)
        graph, cells = contracted(free, core)
    assert len(graph.order) == len(set(graph.order.tolist())) == max(0, len(cells) - core)
    assert_lengths_are_kept(free, graph, cells)


@given(free=maps(12), seed=st.integers(0, 9))
@settings(max_examples=examples(20))
def test_nodes_are_contracted_by_given_costs(free, seed):
    nodes = len(graph_of(free).positions)
    costs = np.random.default_rng(seed).permutation(nodes).astype(np.int32)
    graph, cells = contracted(free, 0, costs)
    turns = np.empty(nodes, np.int64)
    turns[graph.order] = np.arange(nodes)
    for node in range(nodes):
        for edge in edges_of(graph, node):
            to = graph.edges[edge, TO]
            assert costs[to] > costs[node]
            assert turns[to] > turns[node]
    assert_lengths_are_kept(free, graph, cells)


def test_shortcut_is_as_long_as_its_parts_in_both_directions():
    graph, _ = contracted(np.random.default_rng(3).random((60, 60)) > 0.15, 20)
    forth, back = graph.edges[::2], graph.edges[1::2]
    short = forth[:, LEFT] >= 0
    assert short.any()
    parts = graph.edges[forth[short, LEFT]], graph.edges[forth[short, RIGHT]]
    assert (parts[0][:, LENGTH] + parts[1][:, LENGTH] == forth[short, LENGTH]).all()
    assert (parts[0][:, TO] == back[short, TO]).all()
    assert (parts[1][:, TO] == forth[short, TO]).all()
    assert (forth[:, LENGTH] == back[:, LENGTH]).all()
    assert (forth[short, LEFT] == back[short, RIGHT]).all()


@pytest.mark.parametrize("neighbours", [4, 16])
def test_contraction_does_not_depend_on_threads_or_memory(neighbours, monkeypatch):
    free = np.random.default_rng(4).random((70, 70)) > 0.12
    monkeypatch.setattr(contractions, "MOST_NEIGHBOURS", neighbours)
    usual, _ = contracted(free, 10)
    monkeypatch.setattr(contractions, "PAIRS", 8)
    monkeypatch.setattr(contractions, "FEW", 1)
    other, _ = contracted(free, 10, threads=2)
    for name in ("head", "edges", "levels", "order"):
        np.testing.assert_array_equal(getattr(usual, name), getattr(other, name))


PILLARS = np.ones((6, 6), bool)
PILLARS[np.ix_((1, 4), (1, 4))] = False


def edges_in(free) -> RankedEdges:
    graph = build_corner_graph(build_corner_map(free, threads=1, check=proceed), threads=1, check=proceed)
    nodes = np.arange(len(graph.starts) - 1, dtype=np.int32)
    return edges_of_importance(Contraction(graph, most_edge_visits=-1).run(check=proceed), nodes, nodes)


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
