"""The labels of the core contain exactly the necessary hubs, on any number of threads."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidPlanner
from ppaas.planners.hub_labels.building import labels
from ppaas.planners.hub_labels.building.importance import RankedEdges
from ppaas.planners.hub_labels.building.labels import CoreLabels, LabelPool
from ppaas.planners.watch import proceed
from tests.reference.planners.hub_labels import hubs_of

Lengths = dict[tuple[int, int], int]


@st.composite
def graphs(draw: st.DrawFn) -> tuple[int, Lengths]:
    """Draw the number of nodes and the lengths of edges between some pairs."""
    nodes = draw(st.integers(1, 24))
    pairs = st.tuples(st.integers(0, nodes - 1), st.integers(0, nodes - 1)).filter(lambda pair: pair[0] < pair[1])
    return nodes, draw(st.dictionaries(pairs, st.integers(1, 6), max_size=60)) if nodes > 1 else {}


def edges_in(nodes: int, lengths: Lengths) -> RankedEdges:
    """Return the edges of a graph; those of a pair have the numbers e and e ^ 1."""
    pairs = enumerate(lengths.items())
    both = sorted((*end, length, 2 * i + j) for i, ((a, b), length) in pairs for j, end in enumerate([(a, b), (b, a)]))
    starts = np.searchsorted([row[0] for row in both], np.arange(nodes + 1)).astype(np.int64)
    to, far, ids = np.array([row[1:] for row in both], np.int32).reshape(-1, 3).T.copy()
    return RankedEdges(starts, to, far, ids)


def labels_of(nodes: int, lengths: Lengths, *, batches: tuple[int, int, int], threads: int, capacity: int = 1):
    """Return the label of each node as (hub, length, edge towards it), from a pool of an initial ``capacity``."""
    pool = LabelPool(np.arange(nodes, dtype=np.int32))
    pool.hubs, pool.lengths, pool.towards = np.empty((3, capacity), np.int32)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(labels, "FEW", 0)
        for name, value in zip(("LEAST_BATCH", "MOST_BATCH", "NODES_A_SEARCH"), batches, strict=True):
            patch.setattr(labels, name, value)
        assert CoreLabels(pool, edges_in(nodes, lengths), nodes, longest=1000, threads=threads).label(10**6, proceed)
    assert pool.labelled == nodes
    entries = np.column_stack((pool.hubs, pool.lengths, pool.towards)).tolist()
    return [entries[begin:end] for begin, end in zip(pool.begins, pool.ends, strict=True)]


@given(graph=graphs(), batches=st.sampled_from([(1, 1, 1), (2, 8, 1), (4, 64, 16), (30, 30, 1)]))
def test_label_hubs_agree_with_the_twin(graph, batches):
    nodes, lengths = graph
    labels = labels_of(nodes, lengths, batches=batches, threads=1)
    assert [{hub: length for hub, length, _ in label} for label in labels] == hubs_of(nodes, lengths)
    assert all(label == sorted(label) for label in labels)


@given(graph=graphs(), batches=st.sampled_from([(1, 1, 1), (2, 8, 1), (4, 64, 16), (30, 30, 1)]))
def test_edge_towards_a_hub_leads_to_a_node_with_that_hub(graph, batches):
    nodes, lengths = graph
    pairs = list(lengths.items())
    labels = labels_of(nodes, lengths, batches=batches, threads=1)
    for node, label in enumerate(labels):
        for hub, length, edge in label:
            if edge < 0:
                assert (hub, length) == (node, 0)
                continue
            ends, step = pairs[edge >> 1]
            assert ends[edge & 1] == node
            beyond = {other: rest for other, rest, _ in labels[ends[1 - (edge & 1)]]}
            assert beyond[hub] == length - step


def test_labels_do_not_depend_on_threads():
    drawn = np.random.default_rng(2).integers(0, 400, (1500, 2)).tolist()
    lengths = {(a, b): 1 + (7 * a + b) % 50 for a, b in drawn if a < b}
    one, two, three = (labels_of(400, lengths, batches=(4, 64, 16), threads=threads) for threads in (1, 2, 3))
    assert one == two == three


def test_labelling_stops_at_the_entry_limit():
    lengths = {(node, node + 1): 1 for node in range(99)}
    pool = LabelPool(np.arange(100, dtype=np.int32))
    assert not CoreLabels(pool, edges_in(100, lengths), 100, longest=1000, threads=1).label(150, proceed)


def test_too_long_distance_is_refused():
    pool = LabelPool(np.arange(3, dtype=np.int32))
    labelling = CoreLabels(pool, edges_in(3, {(0, 1): 60_000, (1, 2): 60_000}), 3, longest=100_000, threads=1)
    with pytest.raises(InvalidPlanner, match="too long"):
        labelling.label(100, proceed)
