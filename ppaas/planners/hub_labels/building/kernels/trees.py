"""Kernel: shortest-path trees from many roots, on all cores, in slices.

Each *slot* grows its own trees, one after the other: slot s of S those of roots s, s + S, s + 2 S … Slots share no
memory that is written, and a slice may end in the middle of a tree.

Among paths of equal length, a tree contains the one with the shortest last edge: such paths pass through many nodes.
Remaining ties go to the parent with the larger number.
"""

import numpy as np
from numba import prange
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare, compiled, joined
from ppaas.kernel_threads import limit_threads
from ppaas.planners.hub_labels.building.kernels.bucket_queue import Entries, next_bucket, put, take
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.heap import NODE
from ppaas.planners.hub_labels.kernels.layout import FAR
from ppaas.planners.hub_labels.kernels.scan import Integers

Rows = NDArray[np.int32]
Heaps = NDArray[np.int64]

TREE, QUEUED, SETTLED, BUCKET, PUTS, STATE = range(6)
"""State of a slot: its tree, size of its queue, settled nodes (−1: not begun), current bucket of the queue, and number
of insertions."""


@bare
def _begin(root: int, lengths: Integers, parents: Integers, buckets: Integers, entries: Entries, state: Words) -> None:
    lengths[:] = FAR
    parents[:] = -1
    lengths[root] = 0
    state[PUTS] = put(buckets, entries, 0, 0, root)
    state[QUEUED] = 1
    state[BUCKET] = state[SETTLED] = 0


@bare
def _sum_up(tree: int, settled: Integers, count: int, parents: Rows, sizes: Rows, firsts: Rows, nexts: Rows) -> None:
    sizes[tree] = 0
    firsts[tree] = -1
    nexts[tree] = -1
    # Subtree sizes and child lists, from the farthest node back.
    for i in range(count - 1, -1, -1):
        node = settled[i]
        sizes[tree, node] += 1
        parent = parents[tree, node]
        if parent >= 0:
            sizes[tree, parent] += sizes[tree, node]
            nexts[tree, node] = firsts[tree, parent]
            firsts[tree, parent] = node


@joined
def _is_after(node: int, other: int, reach: Integers) -> bool:
    """Return whether a node is farther away than another one, or equally far with a larger number."""
    return bool(reach[node] > reach[other] or (reach[node] == reach[other] and node > other))


@bare
def _grow_slot(
    starts: Words, to: Integers, far: Integers, roots: Integers, state: Words, reach: Integers,
    buckets: Integers, entries: Entries, settled: Integers, parents: Rows, sizes: Rows, firsts: Rows, nexts: Rows,
    slots: int, budget: int,
) -> None:  # fmt: skip
    work = 0
    while state[TREE] < len(roots) and work < budget:
        tree = state[TREE]
        if state[SETTLED] < 0:
            _begin(roots[tree], reach, parents[tree], buckets, entries, state)
            work += len(reach) >> 3
        while state[QUEUED] > 0 and work < budget:
            state[BUCKET] = next_bucket(buckets, state[BUCKET])
            key = take(buckets, entries, state[BUCKET])
            state[QUEUED] -= 1
            node, length = key & NODE, key >> 32
            if length != reach[node]:
                continue
            settled[state[SETTLED]] = node
            state[SETTLED] += 1
            work += starts[node + 1] - starts[node]
            # Dijkstra's algorithm with a bucket queue; ties as described above.
            for edge in range(starts[node], starts[node + 1]):
                further, beyond = length + far[edge], to[edge]
                if further < reach[beyond]:
                    parents[tree, beyond] = node
                    reach[beyond] = further
                    state[PUTS] = put(buckets, entries, state[PUTS], further, beyond)
                    state[QUEUED] += 1
                elif further == reach[beyond] and _is_after(node, parents[tree, beyond], reach):
                    parents[tree, beyond] = node
        if state[QUEUED] == 0:
            _sum_up(tree, settled, state[SETTLED], parents, sizes, firsts, nexts)
            state[TREE] += slots
            state[SETTLED] = -1


@bare
def _grow_serial(
    starts: Words, to: Integers, far: Integers, roots: Integers, states: Heaps, lengths: Rows,
    buckets: Rows, entries: Heaps, settled: Rows, parents: Rows, sizes: Rows, firsts: Rows, nexts: Rows, budget: int,
) -> None:  # fmt: skip
    for slot in range(len(states)):
        _grow_slot(
            starts, to, far, roots, states[slot], lengths[slot], buckets[slot], entries[slot], settled[slot],
            parents, sizes, firsts, nexts, len(states), budget,
        )  # fmt: skip


@compiled(parallel=True)
def _grow_parallel(
    starts: Words, to: Integers, far: Integers, roots: Integers, states: Heaps, lengths: Rows,
    buckets: Rows, entries: Heaps, settled: Rows, parents: Rows, sizes: Rows, firsts: Rows, nexts: Rows, budget: int,
) -> None:  # fmt: skip
    for slot in prange(len(states)):
        _grow_slot(
            starts, to, far, roots, states[slot], lengths[slot], buckets[slot], entries[slot], settled[slot],
            parents, sizes, firsts, nexts, len(states), budget,
        )  # fmt: skip


def grow(
    starts: Words, to: Integers, far: Integers, roots: Integers, states: Heaps, lengths: Rows,
    buckets: Rows, entries: Heaps, settled: Rows, parents: Rows, sizes: Rows, firsts: Rows, nexts: Rows,
    budget: int, threads: int,
) -> None:  # fmt: skip
    """Grow trees until the budget of each slot is used, or all are done.

    Parameters
    ----------
    starts : (n + 1,) int64 array
        First edge of each node.
    to, far : (m,) int32 arrays
        End and length of each edge. No edge is shorter than a straight move.
    roots : (k,) int32 array
        Root of each tree.
    states : (s, `STATE`) int64 array
        State of each slot; at first slot i has tree i and −1 settled nodes. A slot is done when its tree is k or more.
    lengths : (s, n) int32 array
        Scratch: distances from the root.
    buckets : (s, b) int32 array
        Scratch: bucket queue, −1 at first; b from `buckets_for`.
    entries : (s, m + 1, `ENTRY`) int64 array
        Scratch: entries of the queue.
    settled : (s, n) int32 array
        Scratch: settled nodes, in order.
    parents : (k, n) int32 array
        Out: previous node on the path from the root; −1 for the root and unreachable nodes.
    sizes, firsts, nexts : (k, n) int32 arrays
        Out: size of the subtree at each node, its first child, and the next child of its parent, or −1.
    budget : int
        Limit of the work of a slot in this call.
    threads : int
        Maximum number of threads.
    """
    with limit_threads(threads) as usable:
        kernel = _grow_parallel if usable > 1 else _grow_serial
        kernel(
            starts, to, far, roots, states, lengths, buckets, entries, settled, parents, sizes, firsts, nexts, budget
        )


def warm() -> None:
    """Compile and call each kernel once."""
    nothing = np.empty(0, np.int32)
    for threads in (1, 2):
        rows = np.zeros((1, 1), np.int32)
        states, entries = np.array([[0, 0, -1, 0, 0]]), np.zeros((1, 1, 2), np.int64)
        grow(
            np.zeros(2, np.int64), nothing, nothing, np.zeros(1, np.int32), states, rows, rows - 1, entries,
            rows.copy(), rows.copy(), rows.copy(), rows.copy(), rows.copy(), 100, threads,
        )  # fmt: skip
