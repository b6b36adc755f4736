"""A bucket queue returns nodes by length; labels give the distances of all corners from a root."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from ppaas.planners.hub_labels.building.kernels.bucket_queue import ENTRY, WIDTH, buckets_for, next_bucket, put, take
from ppaas.planners.hub_labels.building.kernels.pool_distances import lengths_from
from ppaas.planners.hub_labels.kernels.heap import NODE
from ppaas.planners.hub_labels.kernels.layout import FAR
from ppaas.planners.hub_labels.kernels.scan import STRAIGHT
from tests.reference.planners import hub_labels as twin
from tests.support.budget import examples
from tests.unit.ppaas.planners.hub_labels.building.test_gates import fringe_of
from tests.unit.ppaas.planners.hub_labels.kernels.test_scan import maps

LONGEST = 20 * STRAIGHT


@njit
def run(firsts, edges, buckets, entries, taken):
    """Insert the first nodes; then, for each removed node, insert another one, an edge farther away."""
    inserted = 0
    for node in range(len(firsts)):
        inserted = put(buckets, entries, inserted, firsts[node], node)
    bucket = 0
    for i in range(len(taken)):
        bucket = next_bucket(buckets, bucket)
        taken[i] = take(buckets, entries, bucket)
        if inserted < len(taken):
            inserted = put(buckets, entries, inserted, (taken[i] >> 32) + edges[inserted - len(firsts)], inserted)


@given(
    firsts=st.lists(st.integers(0, LONGEST), min_size=1, max_size=10),
    edges=st.lists(st.integers(STRAIGHT, LONGEST), max_size=200),
)
def test_nodes_are_taken_once_in_bucket_order(firsts, edges):
    count = len(firsts) + len(edges)
    buckets, taken = np.full(buckets_for(LONGEST), -1, np.int32), np.empty(count, np.int64)
    run(np.array(firsts), np.array(edges, np.int64), buckets, np.empty((count, ENTRY), np.int64), taken)
    lengths, nodes = taken >> 32, taken & NODE
    assert sorted(nodes.tolist()) == list(range(count))
    assert (np.diff(lengths >> WIDTH) >= 0).all()
    assert (buckets == -1).all()
    assert [lengths[nodes == node][0] for node in range(len(firsts))] == firsts


@pytest.mark.parametrize("longest", [STRAIGHT, 8191, 8192, LONGEST, 2**29])
def test_longest_edge_leads_to_another_bucket(longest):
    buckets = buckets_for(longest)
    assert buckets & (buckets - 1) == 0
    for length in (0, (1 << WIDTH) - 1):
        assert 0 < ((length + longest) >> WIDTH) - (length >> WIDTH) < buckets


@given(free=maps(14))
@settings(max_examples=examples(15))
def test_distances_from_a_root_agree_with_the_twin(free):
    pool, _, cells, _ = fringe_of(free, 60)
    of_root, far = np.full((2, pool.labelled), FAR, np.int32)
    for root in range(pool.labelled):
        lengths_from(root, pool.labelled, pool.hubs, pool.lengths, pool.begins, pool.ends, of_root, far)
        assert (of_root == FAR).all()
        lengths = twin.lengths_from(free, cells[root])
        for node in range(pool.labelled):
            distance = far[node] / STRAIGHT if far[node] < FAR else math.inf
            assert distance == pytest.approx(lengths[cells[node]])
