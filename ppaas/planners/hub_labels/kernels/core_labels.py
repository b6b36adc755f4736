"""Kernel: label the core by pruned searches, one from each node in the order of importance.

The label of a node is a list of *hubs*, with how far each is: on a shortest way between any two nodes lies a hub that
both have. A search from a node gives itself as a hub to all that it reaches, but does not go on where hubs given before
tell a way as short (Akiba, Iwata and Yoshida, "Fast Exact Shortest-Path Distance Queries on Large Networks by Pruned
Landmark Labeling", SIGMOD 2013). Nodes are numbered by their importance here, 0 the most important.

Labels lie in one *pool* of (hub, length, edge towards it) each, that of a node from ``begins`` to ``ends``. One that is
full is moved to the pool's end, with room for twice as many.
"""

import numpy as np

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.heap import NODE, pop, push
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.hub_labels.kernels.trees import FAR
from ppaas.planners.kernels.bare import bare, joined

FIRST_ROOM = 8

ROOT, QUEUED, TOUCHED, POOL, WIDEST, TOO_LONG, LIVE = range(7)
"""What is counted in ``state``: the root, the size of its heap or −1, nodes that it touched, entries of the pool in
use, entries of the widest label, whether a way was longer than a label may tell, and entries of all labels."""


@joined
def least(reach: Integers, hubs: Integers, lengths: Integers, begin: int, end: int) -> int:
    """Return the least of reach[hub] + length over a stretch of labels; `FAR` or more if no hub is reached."""
    best = np.int32(0x7FFFFFFF)
    for i in range(begin, end):
        best = min(best, np.int32(reach[np.uint64(hubs[i])] + lengths[i]))
    return int(best)


@bare
def _append(
    node: int, hub: int, length: int, edge: int, hubs: Integers, lengths: Integers, edges: Integers,
    begins: Words, ends: Words, rooms: Integers, state: Words,
) -> None:  # fmt: skip
    count = ends[node] - begins[node]
    if count == rooms[node]:
        begin = state[POOL]
        rooms[node] = max(FIRST_ROOM, 2 * rooms[node])
        state[POOL] += rooms[node]
        state[WIDEST] = max(state[WIDEST], rooms[node])
        for i in range(count):
            hubs[begin + i] = hubs[begins[node] + i]
            lengths[begin + i] = lengths[begins[node] + i]
            edges[begin + i] = edges[begins[node] + i]
        begins[node] = begin
        ends[node] = begin + count
    hubs[ends[node]] = hub
    lengths[ends[node]] = length
    edges[ends[node]] = edge
    ends[node] += 1
    state[LIVE] += 1


@bare
def label_core(
    core: int, starts: Words, to: Integers, far: Integers, ids: Integers,
    hubs: Integers, lengths: Integers, edges: Integers, begins: Words, ends: Words, rooms: Integers,
    reach: Integers, came: Integers, of_root: Integers, touched: Integers, heap: Words, state: Words,
    longest: int, budget: int,
) -> bool:  # fmt: skip
    """Label nodes until so many edges and hubs were looked at, or the pool is short; return whether all is done.

    Parameters
    ----------
    core : int
        Nodes of the core; they are the first.
    starts, to, far, ids
        The graph: where the edges of a node begin, where each leads, how long it is and its number; that of the edge
        back is its number ^ 1.
    hubs, lengths, edges : (m,) int32 arrays
        The pool: hub, length, and the number of the edge to go towards it, −1 if the node is the hub.
    begins, ends : int64 arrays
    rooms : (at least ``core``,) int32 array
        Entries for which a label has room, 0 at first.
    reach, of_root : (at least ``core``,) int32 arrays
        `FAR` everywhere at first.
    came, touched : (at least ``core``,) int32 arrays
    heap : (edges of the core + 1,) int64 array
        Scratch.
    state : (7,) int64 array
        Zeros but for −1 at `QUEUED` at first.
    longest : int
        How long a way may be; `TOO_LONG` tells if one is longer.
    budget : int
    """
    work = 0
    while state[ROOT] < core and work < budget:
        root = state[ROOT]
        if state[QUEUED] < 0:
            reach[root] = 0
            came[root] = -1
            touched[0] = root
            state[TOUCHED] = 1
            state[QUEUED] = push(heap, 0, 0, root)
            for i in range(begins[root], ends[root]):
                of_root[hubs[i]] = lengths[i]
        while state[QUEUED] > 0 and work < budget:
            if state[POOL] + 2 * state[WIDEST] + FIRST_ROOM > len(hubs):
                return False
            node, length = heap[0] & NODE, heap[0] >> 32
            state[QUEUED] = pop(heap, state[QUEUED])
            if length != reach[node]:
                continue
            work += 4 + ((ends[node] - begins[node]) >> 3)
            if least(of_root, hubs, lengths, begins[node], ends[node]) <= length:
                continue
            _append(node, root, length, came[node], hubs, lengths, edges, begins, ends, rooms, state)
            work += starts[node + 1] - starts[node]
            for edge in range(starts[node], starts[node + 1]):
                further, beyond = length + far[edge], to[edge]
                if further > longest:
                    state[TOO_LONG] = 1
                elif beyond > root and further < reach[beyond]:
                    if reach[beyond] == FAR:
                        touched[state[TOUCHED]] = beyond
                        state[TOUCHED] += 1
                    reach[beyond] = further
                    came[beyond] = ids[edge] ^ 1
                    state[QUEUED] = push(heap, state[QUEUED], further, beyond)
        if state[QUEUED] == 0:
            for i in range(begins[root], ends[root]):
                of_root[hubs[i]] = FAR
            for i in range(state[TOUCHED]):
                reach[touched[i]] = FAR
            state[ROOT] += 1
            state[QUEUED] = -1
    return bool(state[ROOT] == core)


@bare
def tell_lengths(
    root: int, labelled: int, hubs: Integers, lengths: Integers, begins: Words, ends: Words,
    of_root: Integers, far: Integers,
) -> None:  # fmt: skip
    """Tell how far nodes are from one, by their labels.

    Parameters
    ----------
    root, labelled : int
        The node, and how many nodes have labels; they are the first.
    hubs, lengths, begins, ends
        The labels.
    of_root : (``labelled``,) int32 array
        `FAR` everywhere, before and after.
    far : (``labelled``,) int32 array
        Out; `FAR` or more where there is no way.
    """
    for i in range(begins[root], ends[root]):
        of_root[hubs[i]] = lengths[i]
    for node in range(labelled):
        far[node] = least(of_root, hubs, lengths, begins[node], ends[node])
    for i in range(begins[root], ends[root]):
        of_root[hubs[i]] = FAR


def warm() -> None:
    """Compile and call each kernel once."""
    nothing, whole = np.empty(0, np.int32), np.zeros(1, np.int32)
    label_core(
        0, np.zeros(1, np.int64), nothing, nothing, nothing, nothing, nothing, nothing,
        np.zeros(1, np.int64), np.zeros(1, np.int64), whole, whole, whole, whole, whole, np.zeros(1, np.int64),
        np.zeros(7, np.int64), 0, 0,
    )  # fmt: skip
    tell_lengths(0, 0, nothing, nothing, np.zeros(1, np.int64), np.zeros(1, np.int64), nothing, nothing)
