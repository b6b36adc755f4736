"""A contracted graph keeps all distances: upward paths from both ends meet."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.planners.hub_labels.building import contraction as contractions
from ppaas.planners.hub_labels.building.contraction import ANY_COST, Contraction
from ppaas.planners.hub_labels.building.graph import build_corner_graph, build_corner_map
from ppaas.planners.hub_labels.building.kernels.contraction import LEFT, LENGTH, RIGHT, TO
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
