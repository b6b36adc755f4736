"""Kernel: pruned searches from core nodes for the nodes of which they are hubs, in batches, on all cores.

The label of a node is a list of *hubs* with their distances. On a shortest path between any two nodes is a hub of both.
A search from a node adds it as a hub to all nodes that it reaches, but is pruned where earlier hubs already give a path
as short (pruned landmark labelling; Akiba, Iwata and Yoshida, "Fast Exact Shortest-Path Distance Queries on Large
Networks by Pruned Landmark Labeling", SIGMOD 2013). The test runs when a node is reached, before it enters the heap:
four of five reached nodes are pruned.

Nodes are numbered by importance, 0 the most important. Nodes of a batch do not know each other as hubs, so
`core_labels.add_entries` filters the results. Each *slot* searches from its own nodes: slot s of S from nodes s, s + S,
s + 2 S … of the batch.
"""

import numpy as np
from numba import prange
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare, compiled, joined
from ppaas.kernel_threads import limit_threads
from ppaas.planners.hub_labels.building.kernels.pool_distances import clear, length_up_to, prefetch, scatter
from ppaas.planners.hub_labels.building.kernels.trees import Heaps, Rows
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.heap import NODE, pop, push
from ppaas.planners.hub_labels.kernels.layout import FAR
from ppaas.planners.hub_labels.kernels.scan import Integers

Entries = NDArray[np.int32]

NEXT, QUEUED, TOUCHED, USED, TOO_LONG = range(5)
"""State of a slot: its next node in the batch, size of its heap (−1: search not begun), reached nodes, entries found,
and whether a path was too long."""

REACH, EDGE_BACK, FROM_ROOT, TOUCHED_NODES, CANDIDATES, SCRATCH = range(6)
"""Scratch arrays of a slot: distance of each node, edge back from it, distances of hubs from the root, reached nodes,
and edges to nodes whose labels are tested."""

HUB_OF, LENGTH, TOWARDS = range(3)
"""Columns of a result: node that has the root as a hub, its distance, and its edge towards the root."""


@joined
def _begin_search(
    root: int, hubs: Integers, lengths: Integers, begins: Words, ends: Words, own: Rows, heap: Words
) -> None:
    own[REACH, root] = 0
    own[EDGE_BACK, root] = -1
    own[TOUCHED_NODES, 0] = root
    push(heap, 0, 0, root)
    scatter(own[FROM_ROOT], hubs, lengths, begins[root], ends[root])


@joined
def _end_search(root: int, hubs: Integers, begins: Words, ends: Words, own: Rows, touched: int) -> None:
    clear(own[FROM_ROOT], hubs, begins[root], ends[root])
    for i in range(touched):
        own[REACH, own[TOUCHED_NODES, i]] = FAR


@joined
def _collect_edges(
    root: int, length: int, first: int, last: int, to: Integers, far: Integers,
    hubs: Integers, lengths: Integers, begins: Words, own: Rows, longest: int, state: Words,
) -> int:  # fmt: skip
    """Collect the edges that shorten paths to nodes, prefetch the labels of these nodes, and return their number."""
    count = 0
    for edge in range(first, last):
        further, beyond = length + far[edge], to[edge]
        own[CANDIDATES, count] = edge - first
        if beyond > root and further < own[REACH, beyond]:
            prefetch(hubs, lengths, begins[beyond])
            count += 1
            if further > longest:
                state[TOO_LONG] = 1
    return count


@bare
def _search_slot(
    first: int, batch: int, starts: Words, to: Integers, far: Integers, ids: Integers,
    hubs: Integers, lengths: Integers, begins: Words, ends: Words,
    own: Rows, heap: Words, found: Rows, bounds: Words, state: Words, slots: int, longest: int, budget: int,
) -> None:  # fmt: skip
    work = np.int64(0)
    reach, edge_back, from_root = own[REACH], own[EDGE_BACK], own[FROM_ROOT]
    while state[NEXT] < batch and work < budget:
        root = first + state[NEXT]
        if state[QUEUED] < 0:
            if state[USED] + len(reach) - root > len(found):
                return
            _begin_search(root, hubs, lengths, begins, ends, own, heap)
            state[QUEUED] = state[TOUCHED] = 1
        while state[QUEUED] > 0 and work < budget:
            node, length = heap[0] & NODE, heap[0] >> 32
            state[QUEUED] = pop(heap, state[QUEUED])
            if length != reach[node]:
                continue
            # Settle the node: the root is one of its hubs.
            found[state[USED], HUB_OF] = node
            found[state[USED], LENGTH] = length
            found[state[USED], TOWARDS] = edge_back[node]
            state[USED] += 1
            begin, end = starts[node], starts[node + 1]
            # Relax edges to less important nodes, unless labels already cover them (pruning).
            candidates = _collect_edges(root, length, begin, end, to, far, hubs, lengths, begins, own, longest, state)
            work += end - begin + 8 * candidates
            for i in range(candidates):
                edge = begin + own[CANDIDATES, i]
                further, beyond = length + far[edge], to[edge]
                if reach[beyond] == FAR:
                    own[TOUCHED_NODES, state[TOUCHED]] = beyond
                    state[TOUCHED] += 1
                shortest = length_up_to(from_root, hubs, lengths, begins[beyond], ends[beyond], further)
                if shortest <= further:
                    reach[beyond] = shortest
                else:
                    reach[beyond] = further
                    edge_back[beyond] = ids[edge] ^ 1
                    state[QUEUED] = push(heap, state[QUEUED], further, beyond)
        if state[QUEUED] == 0:
            _end_search(root, hubs, begins, ends, own, state[TOUCHED])
            bounds[state[NEXT] + slots] = state[USED]
            state[NEXT] += slots
            state[QUEUED] = -1


@bare
def _search_serial(
    first: int, batch: int, starts: Words, to: Integers, far: Integers, ids: Integers,
    hubs: Integers, lengths: Integers, begins: Words, ends: Words,
    own: Entries, heaps: Heaps, found: Entries, bounds: Words, states: Heaps, longest: int, budget: int,
) -> None:  # fmt: skip
    for slot in range(len(states)):
        _search_slot(
            first, batch, starts, to, far, ids, hubs, lengths, begins, ends,
            own[slot], heaps[slot], found[slot], bounds, states[slot], len(states), longest, budget,
        )  # fmt: skip


@compiled(parallel=True)
def _search_parallel(
    first: int, batch: int, starts: Words, to: Integers, far: Integers, ids: Integers,
    hubs: Integers, lengths: Integers, begins: Words, ends: Words,
    own: Entries, heaps: Heaps, found: Entries, bounds: Words, states: Heaps, longest: int, budget: int,
) -> None:  # fmt: skip
    for slot in prange(len(states)):
        _search_slot(
            first, batch, starts, to, far, ids, hubs, lengths, begins, ends,
            own[slot], heaps[slot], found[slot], bounds, states[slot], len(states), longest, budget,
        )  # fmt: skip


def search(
    first: int, batch: int, starts: Words, to: Integers, far: Integers, ids: Integers,
    hubs: Integers, lengths: Integers, begins: Words, ends: Words,
    own: Entries, heaps: Heaps, found: Entries, bounds: Words, states: Heaps, longest: int, budget: int, threads: int,
) -> None:  # fmt: skip
    """Search until the budget of each slot is used, its result memory is full, or the batch is done.

    Parameters
    ----------
    first, batch : int
        First node of the batch, and number of its nodes. Earlier nodes are hubs already. The core has n nodes.
    starts : (n + 1,) int64 array
        First edge of each node.
    to, far, ids : int32 arrays
        End, length and number of each edge. The reverse of edge e is e ^ 1.
    hubs, lengths, begins, ends
        Pool of labels, as in `core_labels.add_entries`.
    own : (S, `SCRATCH`, n) int32 array
        Scratch of each slot; `FAR` at first.
    heaps : (S, edges + 1) int64 array
        Scratch: heap of each slot.
    found : (S, m, 3) int32 array
        Out: results of each slot, root by root; m is at least n.
    bounds : (S + ``batch``,) int64 array
        Out: results of root i of the batch are at ``bounds[i]:bounds[i + S]`` of its slot; zero at first.
    states : (S, 5) int64 array
        State of each slot; at first the next node is i for slot i, `QUEUED` is −1, and the rest is zero.
    longest : int
        Largest length of a path; `TOO_LONG` becomes 1 if one is longer.
    budget : int
        Limit of the work of a slot in this call.
    threads : int
        Maximum number of threads.
    """
    with limit_threads(threads) as usable:
        kernel = _search_parallel if usable > 1 else _search_serial
        kernel(
            first, batch, starts, to, far, ids, hubs, lengths, begins, ends,
            own, heaps, found, bounds, states, longest, budget,
        )  # fmt: skip


def warm() -> None:
    """Compile and call each kernel once."""
    nothing, far = np.empty(0, np.int32), np.zeros(1, np.int64)
    for threads in (1, 2):
        search(
            0, 0, far, nothing, nothing, nothing, nothing, nothing, far, far,
            np.zeros((1, SCRATCH, 1), np.int32), np.zeros((1, 1), np.int64), np.zeros((1, 1, 3), np.int32), far,
            np.zeros((1, 5), np.int64), 0, 0, threads,
        )  # fmt: skip
