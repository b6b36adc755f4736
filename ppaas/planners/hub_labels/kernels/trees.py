"""Kernel: trees of shortest ways from many roots, on all cores, in slices.

Each *slot* grows trees of its own, one after the other: slot s of S those of the roots s, s + S, s + 2 S … So slots
share nothing that is written, and a slice may end in the middle of a tree.

Of ways as short as each other a tree has the one whose last edge is the shortest: such ways lead over many nodes.
"""

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.heap import NODE, pop, push
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.kernels.bare import bare
from ppaas.planners.kernels.threads import at_most

Rows = NDArray[np.int32]
Heaps = NDArray[np.int64]

FAR = np.int32(2**30)
"""Longer than any way."""

TREE, QUEUED, SETTLED = range(3)
"""What a slot knows of its work: its tree, the size of its heap, how many nodes it has settled; −1: not begun."""


@bare
def _begin(root: int, lengths: Integers, parents: Integers, heap: Words, state: Words) -> None:
    lengths[:] = FAR
    parents[:] = -1
    lengths[root] = 0
    state[QUEUED] = push(heap, 0, 0, root)
    state[SETTLED] = 0


@bare
def _sum_up(tree: int, settled: Integers, count: int, parents: Rows, sizes: Rows, firsts: Rows, nexts: Rows) -> None:
    sizes[tree] = 0
    firsts[tree] = -1
    nexts[tree] = -1
    for i in range(count - 1, -1, -1):
        node = settled[i]
        sizes[tree, node] += 1
        parent = parents[tree, node]
        if parent >= 0:
            sizes[tree, parent] += sizes[tree, node]
            nexts[tree, node] = firsts[tree, parent]
            firsts[tree, parent] = node


@bare
def _grow_slot(
    starts: Words, to: Integers, far: Integers, roots: Integers, slot: int, state: Words, lengths: Rows, heaps: Heaps,
    settled: Rows, parents: Rows, sizes: Rows, firsts: Rows, nexts: Rows, budget: int,
) -> None:  # fmt: skip
    work = 0
    heap = heaps[slot]
    reach = lengths[slot]
    while state[TREE] < len(roots) and work < budget:
        tree = state[TREE]
        if state[SETTLED] < 0:
            _begin(roots[tree], reach, parents[tree], heap, state)
            work += len(reach) >> 3
        while state[QUEUED] > 0 and work < budget:
            node, length = heap[0] & NODE, heap[0] >> 32
            state[QUEUED] = pop(heap, state[QUEUED])
            if length != reach[node]:
                continue
            settled[slot, state[SETTLED]] = node
            state[SETTLED] += 1
            work += starts[node + 1] - starts[node]
            for edge in range(starts[node], starts[node + 1]):
                further, beyond = length + far[edge], to[edge]
                if further > reach[beyond]:
                    continue
                parents[tree, beyond] = node
                if further < reach[beyond]:
                    reach[beyond] = further
                    state[QUEUED] = push(heap, state[QUEUED], further, beyond)
        if state[QUEUED] == 0:
            if len(sizes):
                _sum_up(tree, settled[slot], state[SETTLED], parents, sizes, firsts, nexts)
            state[TREE] += len(heaps)
            state[SETTLED] = -1


@bare
def _grow_serial(
    starts: Words, to: Integers, far: Integers, roots: Integers, states: Heaps, lengths: Rows, heaps: Heaps,
    settled: Rows, parents: Rows, sizes: Rows, firsts: Rows, nexts: Rows, budget: int,
) -> None:  # fmt: skip
    for slot in range(len(heaps)):
        _grow_slot(
            starts, to, far, roots, slot, states[slot], lengths, heaps, settled, parents, sizes, firsts, nexts, budget
        )


@njit(cache=True, nogil=True, error_model="numpy", parallel=True)
def _grow_parallel(
    starts: Words, to: Integers, far: Integers, roots: Integers, states: Heaps, lengths: Rows, heaps: Heaps,
    settled: Rows, parents: Rows, sizes: Rows, firsts: Rows, nexts: Rows, budget: int,
) -> None:  # fmt: skip
    for slot in prange(len(heaps)):
        _grow_slot(
            starts, to, far, roots, slot, states[slot], lengths, heaps, settled, parents, sizes, firsts, nexts, budget
        )


def grow(
    starts: Words, to: Integers, far: Integers, roots: Integers, states: Heaps, lengths: Rows, heaps: Heaps,
    settled: Rows, parents: Rows, sizes: Rows, firsts: Rows, nexts: Rows, budget: int, threads: int,
) -> None:  # fmt: skip
    """Grow trees until each slot has looked at so many edges, or all is done.

    Parameters
    ----------
    starts : (n + 1,) int64 array
    to, far : (m,) int32 arrays
        The graph: where the edges of a node begin, where each leads and how long it is.
    roots : (k,) int32 array
    states : (s, 3) int64 array
        A slot is done when its tree is k or more; at first slot i has the tree i, and −1 nodes settled.
    lengths : (s, n) int32 array
        Out: how far each node is from the root of the slot's last tree; `FAR` if it cannot be reached.
    heaps : (s, m + 1) int64 array
    settled : (s, n) int32 array
        Scratch.
    parents : (k, n) int32 array
        Out: the node before each on the way from the root; −1 for the root and what cannot be reached.
    sizes, firsts, nexts : (k, n) int32 arrays
        Out: how many nodes hang at a node, itself included; its first child, and the next child of its parent, or −1.
        Not wanted if they have no row.
    budget, threads : int
    """
    with at_most(threads) as usable:
        kernel = _grow_parallel if usable > 1 else _grow_serial
        kernel(starts, to, far, roots, states, lengths, heaps, settled, parents, sizes, firsts, nexts, budget)


def warm() -> None:
    """Compile and call each kernel once."""
    nothing = np.empty(0, np.int32)
    for threads in (1, 2):
        rows = np.zeros((1, 1), np.int32)
        states, heaps = np.array([[0, 0, -1]]), np.zeros((1, 1), np.int64)
        grow(
            np.zeros(2, np.int64), nothing, nothing, np.zeros(1, np.int32), states, rows, heaps,
            rows.copy(), rows.copy(), rows.copy(), rows.copy(), rows.copy(), 100, threads,
        )  # fmt: skip
