"""Kernel: label the nodes outside the core from the labels of the neighbours that were contracted later.

A hub of a neighbour is a hub of the node, one edge farther away, unless another hub gives a path as short. Nodes of one
level have no edges between them, so they are labelled in parallel (Abraham, Delling, Goldberg and Werneck,
"Hierarchical Hub Labelings for Shortest Paths", ESA 2012).

Each slot has its own range of free space in the pool of labels.
"""

import numpy as np
from numba import prange

from ppaas.kernel_cache.decorators import bare, compiled
from ppaas.kernel_threads import limit_threads
from ppaas.planners.hub_labels.building.kernels.pool_distances import clear, length_up_to
from ppaas.planners.hub_labels.building.kernels.trees import Heaps, Rows
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.kernels.bits import trailing_zeros


@bare
def _gather_candidates(
    node: int, starts: Words, to: Integers, far: Integers, ids: Integers,
    hubs: Integers, lengths: Integers, begins: Words, ends: Words,
    reach: Integers, by_edge: Integers, marks: Words, longest: int,
) -> bool:  # fmt: skip
    """Collect the hubs of all neighbours with their distances; return whether no path is too long."""
    all_short = True
    for edge in range(starts[node], starts[node + 1]):
        above = to[edge]
        for i in range(begins[above], ends[above]):
            hub, length = hubs[i], lengths[i] + far[edge]
            if length > longest:
                all_short = False
            elif length < reach[hub]:
                reach[hub] = length
                by_edge[hub] = ids[edge]
                marks[hub >> 6] |= np.int64(1) << (hub & 63)
    return all_short


@bare
def _write_label(
    node: int, hubs: Integers, lengths: Integers, edges: Integers, begins: Words, ends: Words,
    reach: Integers, by_edge: Integers, marks: Words, at: int,
) -> int:  # fmt: skip
    """Write the label of a node at an index of the pool, and return the work done."""
    work = len(marks) >> 3
    begins[node] = at
    for word in range(len(marks)):
        while marks[word]:
            hub = (word << 6) + trailing_zeros(np.uint64(marks[word]))
            marks[word] &= marks[word] - 1
            work += 4 + ((ends[hub] - begins[hub]) >> 3)
            # Keep the hub unless an earlier one gives a path as short (label pruning).
            if length_up_to(reach, hubs, lengths, begins[hub], ends[hub] - 1, reach[hub]) > reach[hub]:
                hubs[at] = hub
                lengths[at] = reach[hub]
                edges[at] = by_edge[hub]
                at += 1
    # A node is its own last hub.
    hubs[at] = node
    lengths[at] = 0
    edges[at] = -1
    ends[node] = at + 1
    return work


@bare
def _merge_slot(
    nodes: Integers, starts: Words, to: Integers, far: Integers, ids: Integers,
    hubs: Integers, lengths: Integers, edges: Integers, begins: Words, ends: Words,
    reach: Integers, by_edge: Integers, marks: Words, window: Words, slots: int, longest: int, budget: int,
) -> None:  # fmt: skip
    work = 0
    while window[0] < len(nodes) and work < budget:
        node = nodes[window[0]]
        most = 1
        for edge in range(starts[node], starts[node + 1]):
            most += int(ends[to[edge]] - begins[to[edge]])
        if window[1] + most > window[2]:
            return
        if not _gather_candidates(
            node, starts, to, far, ids, hubs, lengths, begins, ends, reach, by_edge, marks, longest
        ):
            window[3] = 1
        work += most + _write_label(node, hubs, lengths, edges, begins, ends, reach, by_edge, marks, window[1])
        for edge in range(starts[node], starts[node + 1]):
            clear(reach, hubs, begins[to[edge]], ends[to[edge]])
        window[1] = ends[node]
        window[0] += slots


@bare
def _merge_serial(
    nodes: Integers, starts: Words, to: Integers, far: Integers, ids: Integers,
    hubs: Integers, lengths: Integers, edges: Integers, begins: Words, ends: Words,
    reach: Rows, by_edge: Rows, marks: Heaps, windows: Heaps, longest: int, budget: int,
) -> None:  # fmt: skip
    for slot in range(len(windows)):
        _merge_slot(
            nodes, starts, to, far, ids, hubs, lengths, edges, begins, ends,
            reach[slot], by_edge[slot], marks[slot], windows[slot], len(windows), longest, budget,
        )  # fmt: skip


@compiled(parallel=True)
def _merge_parallel(
    nodes: Integers, starts: Words, to: Integers, far: Integers, ids: Integers,
    hubs: Integers, lengths: Integers, edges: Integers, begins: Words, ends: Words,
    reach: Rows, by_edge: Rows, marks: Heaps, windows: Heaps, longest: int, budget: int,
) -> None:  # fmt: skip
    for slot in prange(len(windows)):
        _merge_slot(
            nodes, starts, to, far, ids, hubs, lengths, edges, begins, ends,
            reach[slot], by_edge[slot], marks[slot], windows[slot], len(windows), longest, budget,
        )  # fmt: skip


def merge(
    nodes: Integers, starts: Words, to: Integers, far: Integers, ids: Integers,
    hubs: Integers, lengths: Integers, edges: Integers, begins: Words, ends: Words,
    reach: Rows, by_edge: Rows, marks: Heaps, windows: Heaps, longest: int, budget: int, threads: int,
) -> None:  # fmt: skip
    """Label the nodes of a level until the budget of each slot is used, its space is full, or all are done.

    Parameters
    ----------
    nodes : (k,) int32 array
        Nodes of the level, numbered by importance; slot s of S takes nodes s, s + S, s + 2 S …
    starts : (n + 1,) int64 array
        First edge of each node.
    to, far, ids : int32 arrays
        End, length and number of each edge to a more important node, which is labelled.
    hubs, lengths, edges, begins, ends
        Pool of labels, as in `core_labels.add_entries`.
    reach, by_edge : (S, n) int32 arrays
        Scratch: distance of each hub, and the edge towards it; `FAR` at first.
    marks : (S, n / 64) int64 array
        Scratch: bit set of candidate hubs; zero at first.
    windows : (S, 4) int64 array
        State of each slot: its next node, begin and end of its free space in the pool, and whether a path was too long.
    longest : int
        Largest length of a path.
    budget : int
        Limit of the work of a slot in this call.
    threads : int
        Maximum number of threads.
    """
    with limit_threads(threads) as usable:
        kernel = _merge_parallel if usable > 1 else _merge_serial
        kernel(
            nodes,
            starts,
            to,
            far,
            ids,
            hubs,
            lengths,
            edges,
            begins,
            ends,
            reach,
            by_edge,
            marks,
            windows,
            longest,
            budget,
        )


def warm() -> None:
    """Compile and call each kernel once."""
    nothing = np.empty(0, np.int32)
    for threads in (1, 2):
        far = np.zeros(1, np.int64)
        rows, marks = np.zeros((1, 1), np.int32), np.zeros((1, 1), np.int64)
        windows = np.zeros((1, 4), np.int64)
        merge(
            nothing, far, nothing, nothing, nothing, nothing, nothing, nothing, far, far,
            rows, rows, marks, windows, 1, 1, threads,
        )  # fmt: skip
