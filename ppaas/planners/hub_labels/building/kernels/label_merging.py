"""Kernel: label the nodes outside the core, each from the labels of the neighbours that were contracted after it.

A hub of a neighbour is a hub of the node, one edge further off; those are left out to which other hubs tell a way as
short. Nodes of one level have no edges between them, so they are labelled on all cores (Abraham, Delling, Goldberg and
Werneck, "Hierarchical Hub Labelings for Shortest Paths", ESA 2012).

Each slot has a window of the pool of labels of its own: ``windows`` tells where its free room begins and ends.
"""

import numpy as np
from numba import njit, prange

from ppaas.kernel_threads import at_most
from ppaas.planners.hub_labels.building.kernels.pool_distances import take_back, told
from ppaas.planners.hub_labels.building.kernels.trees import Heaps, Rows
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.kernels.bits import trailing_zeros
from ppaas.planners.kernels.jit_decorators import bare


@bare
def _gather(
    node: int, starts: Words, to: Integers, far: Integers, ids: Integers,
    hubs: Integers, lengths: Integers, begins: Words, ends: Words,
    reach: Integers, came: Integers, marks: Words, longest: int,
) -> bool:  # fmt: skip
    short = True
    for edge in range(starts[node], starts[node + 1]):
        above = to[edge]
        for i in range(begins[above], ends[above]):
            hub, length = hubs[i], lengths[i] + far[edge]
            if length > longest:
                short = False
            elif length < reach[hub]:
                reach[hub] = length
                came[hub] = ids[edge]
                marks[hub >> 6] |= np.int64(1) << (hub & 63)
    return short


@bare
def _keep(
    node: int, hubs: Integers, lengths: Integers, edges: Integers, begins: Words, ends: Words,
    reach: Integers, came: Integers, marks: Words, at: int,
) -> int:  # fmt: skip
    """Write the label of a node at a place of the pool and return how many hubs were looked at."""
    work = len(marks) >> 3
    begins[node] = at
    for word in range(len(marks)):
        while marks[word]:
            hub = (word << 6) + trailing_zeros(np.uint64(marks[word]))
            marks[word] &= marks[word] - 1
            work += 4 + ((ends[hub] - begins[hub]) >> 3)
            if told(reach, hubs, lengths, begins[hub], ends[hub] - 1, reach[hub]) > reach[hub]:
                hubs[at] = hub
                lengths[at] = reach[hub]
                edges[at] = came[hub]
                at += 1
    hubs[at] = node
    lengths[at] = 0
    edges[at] = -1
    ends[node] = at + 1
    return work


@bare
def _merge_slot(
    nodes: Integers, starts: Words, to: Integers, far: Integers, ids: Integers,
    hubs: Integers, lengths: Integers, edges: Integers, begins: Words, ends: Words,
    reach: Integers, came: Integers, marks: Words, window: Words, slots: int, longest: int, budget: int,
) -> None:  # fmt: skip
    work = 0
    while window[0] < len(nodes) and work < budget:
        node = nodes[window[0]]
        most = 1
        for edge in range(starts[node], starts[node + 1]):
            most += int(ends[to[edge]] - begins[to[edge]])
        if window[1] + most > window[2]:
            return
        if not _gather(node, starts, to, far, ids, hubs, lengths, begins, ends, reach, came, marks, longest):
            window[3] = 1
        work += most + _keep(node, hubs, lengths, edges, begins, ends, reach, came, marks, window[1])
        for edge in range(starts[node], starts[node + 1]):
            take_back(reach, hubs, begins[to[edge]], ends[to[edge]])
        window[1] = ends[node]
        window[0] += slots


@bare
def _merge_serial(
    nodes: Integers, starts: Words, to: Integers, far: Integers, ids: Integers,
    hubs: Integers, lengths: Integers, edges: Integers, begins: Words, ends: Words,
    reach: Rows, came: Rows, marks: Heaps, windows: Heaps, longest: int, budget: int,
) -> None:  # fmt: skip
    for slot in range(len(windows)):
        _merge_slot(
            nodes, starts, to, far, ids, hubs, lengths, edges, begins, ends,
            reach[slot], came[slot], marks[slot], windows[slot], len(windows), longest, budget,
        )  # fmt: skip


@njit(cache=True, nogil=True, error_model="numpy", parallel=True)
def _merge_parallel(
    nodes: Integers, starts: Words, to: Integers, far: Integers, ids: Integers,
    hubs: Integers, lengths: Integers, edges: Integers, begins: Words, ends: Words,
    reach: Rows, came: Rows, marks: Heaps, windows: Heaps, longest: int, budget: int,
) -> None:  # fmt: skip
    for slot in prange(len(windows)):
        _merge_slot(
            nodes, starts, to, far, ids, hubs, lengths, edges, begins, ends,
            reach[slot], came[slot], marks[slot], windows[slot], len(windows), longest, budget,
        )  # fmt: skip


def merge(
    nodes: Integers, starts: Words, to: Integers, far: Integers, ids: Integers,
    hubs: Integers, lengths: Integers, edges: Integers, begins: Words, ends: Words,
    reach: Rows, came: Rows, marks: Heaps, windows: Heaps, longest: int, budget: int, threads: int,
) -> None:  # fmt: skip
    """Label nodes of one level until each slot has looked at so many hubs, or its window is short, or all is done.

    Parameters
    ----------
    nodes : (k,) int32 array
        Numbered by importance; slot s of S takes the nodes s, s + S, s + 2 S …
    starts, to, far, ids
        The graph: edges to more important nodes, which are labelled.
    hubs, lengths, edges, begins, ends
        The pool of labels.
    reach, came : (S, n) int32 arrays
        `FAR` everywhere at first; scratch.
    marks : (S, n / 64) int64 array
        Zero at first.
    windows : (S, 4) int64 array
        The slot's next node, the begin of its free room in the pool, its end, and whether a way was too long.
    longest : int
        How long a way may be.
    budget, threads : int
    """
    with at_most(threads) as usable:
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
            came,
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
