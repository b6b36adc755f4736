"""Kernel: search from nodes of the core for those of which they are hubs, a batch of nodes at a time, on all cores.

The label of a node is a list of *hubs*, with how far each is: on a shortest way between any two nodes lies a hub that
both have. A search from a node gives itself as a hub to all that it reaches, but does not go on where hubs given before
tell a way as short (Akiba, Iwata and Yoshida, "Fast Exact Shortest-Path Distance Queries on Large Networks by Pruned
Landmark Labeling", SIGMOD 2013). That is asked of a node when it is seen, before it is put into the heap: of five that
are seen, four have such a hub.

Nodes are numbered by their importance here, 0 the most important. Those of a batch do not know each other as hubs, so
what a search finds is kept only by `core_labels.keep`. Each *slot* searches from nodes of its own: slot s of S from the
nodes s, s + S, s + 2 S … of the batch.
"""

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from ppaas.kernel_threads import at_most
from ppaas.planners.hub_labels.building.kernels.pool_distances import announce, lay_out, take_back, told
from ppaas.planners.hub_labels.building.kernels.trees import Heaps, Rows
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.heap import NODE, pop, push
from ppaas.planners.hub_labels.kernels.layout import FAR
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.kernels.jit_decorators import bare, joined

Entries = NDArray[np.int32]

NEXT, QUEUED, TOUCHED, USED, TOO_LONG = range(5)
"""What a slot knows of its work: its next node in the batch, the size of its heap or −1, nodes that it has touched,
entries that it has found, and whether a way was longer than a label may tell."""

REACH, CAME, OF_ROOT, SEEN, TO_ASK, SCRATCH = range(6)
"""Scratch of a slot: how far each node is, the edge back from it, how far hubs are from the root, which nodes were
touched, and edges to nodes whose labels are asked."""

HUB_OF, FAR_OFF, TOWARDS = range(3)
"""Of what is found: which node has the root as a hub, how far it is, and the edge towards the root."""


@joined
def _begin(root: int, hubs: Integers, lengths: Integers, begins: Words, ends: Words, own: Rows, heap: Words) -> None:
    own[REACH, root] = 0
    own[CAME, root] = -1
    own[SEEN, 0] = root
    push(heap, 0, 0, root)
    lay_out(own[OF_ROOT], hubs, lengths, begins[root], ends[root])


@joined
def _end(root: int, hubs: Integers, begins: Words, ends: Words, own: Rows, touched: int) -> None:
    take_back(own[OF_ROOT], hubs, begins[root], ends[root])
    for i in range(touched):
        own[REACH, own[SEEN, i]] = FAR


@joined
def _look_around(
    root: int, length: int, first: int, last: int, to: Integers, far: Integers,
    hubs: Integers, lengths: Integers, begins: Words, own: Rows, longest: int, state: Words,
) -> int:  # fmt: skip
    """Write over which edges a node is reached sooner than before, begin to bring its label; return how many."""
    count = 0
    for edge in range(first, last):
        further, beyond = length + far[edge], to[edge]
        own[TO_ASK, count] = edge - first
        if beyond > root and further < own[REACH, beyond]:
            announce(hubs, lengths, begins[beyond])
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
    reach, came, of_root = own[REACH], own[CAME], own[OF_ROOT]
    while state[NEXT] < batch and work < budget:
        root = first + state[NEXT]
        if state[QUEUED] < 0:
            if state[USED] + len(reach) - root > len(found):
                return
            _begin(root, hubs, lengths, begins, ends, own, heap)
            state[QUEUED] = state[TOUCHED] = 1
        while state[QUEUED] > 0 and work < budget:
            node, length = heap[0] & NODE, heap[0] >> 32
            state[QUEUED] = pop(heap, state[QUEUED])
            if length != reach[node]:
                continue
            found[state[USED], HUB_OF] = node
            found[state[USED], FAR_OFF] = length
            found[state[USED], TOWARDS] = came[node]
            state[USED] += 1
            begin, end = starts[node], starts[node + 1]
            asked = _look_around(root, length, begin, end, to, far, hubs, lengths, begins, own, longest, state)
            work += end - begin + 8 * asked
            for i in range(asked):
                edge = begin + own[TO_ASK, i]
                further, beyond = length + far[edge], to[edge]
                if reach[beyond] == FAR:
                    own[SEEN, state[TOUCHED]] = beyond
                    state[TOUCHED] += 1
                known = told(of_root, hubs, lengths, begins[beyond], ends[beyond], further)
                if known <= further:
                    reach[beyond] = known
                else:
                    reach[beyond] = further
                    came[beyond] = ids[edge] ^ 1
                    state[QUEUED] = push(heap, state[QUEUED], further, beyond)
        if state[QUEUED] == 0:
            _end(root, hubs, begins, ends, own, state[TOUCHED])
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


@njit(cache=True, nogil=True, error_model="numpy", parallel=True)
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
    """Search until each slot has looked at so much, or has no room, or all of the batch is done.

    Parameters
    ----------
    first, batch : int
        The first node of the batch, and how many they are. All before have been hubs; there are n nodes.
    starts, to, far, ids
        The graph: where the edges of a node begin, where each leads, how long it is and its number; that of the edge
        back is its number ^ 1.
    hubs, lengths, begins, ends
        The pool of labels.
    own : (S, `SCRATCH`, n) int32 array
        `FAR` everywhere at first.
    heaps : (S, edges + 1) int64 array
        Scratch.
    found : (S, m, 3) int32 array
        Out: entries that a slot finds, root by root; the least of m is n.
    bounds : (S + ``batch``,) int64 array
        Out: the entries of the root i of the batch lie from i to i + S, among those of its slot; zeros at first.
    states : (S, 5) int64 array
        Slot i has the next node i, −1 for `QUEUED`, and no entries at first.
    longest : int
        How long a way may be; `TOO_LONG` tells if one is longer.
    budget, threads : int
    """
    with at_most(threads) as usable:
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
