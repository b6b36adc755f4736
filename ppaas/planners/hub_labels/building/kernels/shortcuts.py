"""Kernel: witness searches: which shortcuts the contraction of each node of a round needs, on all cores.

A search from each neighbour of a node looks for witnesses: paths to the other neighbours that avoid all nodes of the
round and are as short as the path through the node (Geisberger et al., WEA 2008). It prunes a node if its distance plus
the octile distance to every remaining target exceeds the limit of the target. The test repeats when the node is
expanded, as fewer targets may remain by then.

Each *slot* processes its own nodes: slot s of S takes nodes s, s + S, s + 2 S … of the round.
"""

import numpy as np
from numba import prange
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare, compiled, joined
from ppaas.kernel_threads import limit_threads
from ppaas.planners.hub_labels.building.kernels.bucket_queue import ENTRY, WIDTH, Entries, next_bucket, put, take
from ppaas.planners.hub_labels.building.kernels.contraction import FIRST, FOUND, LENGTH_TO, NODE, PAIR_BITS, SLOT, Flags
from ppaas.planners.hub_labels.building.kernels.trees import Heaps, Rows
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.heap import NODE as LOWER
from ppaas.planners.hub_labels.kernels.scan import DIAGONAL, STRAIGHT, Integers

Targets = NDArray[np.int32]

NEXT, USED, SEARCHES, EDGE_VISITS = range(4)
"""State of a slot: its next node, number of pairs written, and total numbers of searches and of edge visits."""

ERA = 1 << 32
"""Gap between the values of consecutive searches. Later searches write smaller values, so arrays need no reset."""

TARGET, LIMIT, ROW, COLUMN = range(4)
"""Rows of the targets: node, limit of the length of a witness, and its row and column."""

WITNESS_FOUND = np.iinfo(np.int64).max
"""Replaces the limit of a target whose witness was found."""

TARGETS_A_VECTOR = 16
"""Targets are padded to a multiple of this number, with targets that cannot be reached."""

_STRAIGHT, _ASIDE = np.int32(STRAIGHT), np.int32(DIAGONAL - STRAIGHT)


@joined
def _padded(wanted: int) -> int:
    return -(-wanted // TARGETS_A_VECTOR) * TARGETS_A_VECTOR


@bare
def _set_targets(
    node: int, first: int, era: int, begins: Words, degrees: Integers, rows: Rows, positions: Rows, limits: Words,
    targets: Rows,
) -> int:  # fmt: skip
    """Write the neighbours after ``first`` as targets, with the limits of their witnesses; return their number."""
    begin, own = begins[node], np.int64(rows[begins[node] + first, LENGTH_TO])
    wanted = 0
    for at in range(begin + first + 1, begin + degrees[node]):
        other, limit = rows[at, NODE], own + rows[at, LENGTH_TO]
        limits[other] = era + limit
        targets[TARGET, wanted] = other
        targets[LIMIT, wanted] = limit
        targets[ROW, wanted] = positions[other, 0]
        targets[COLUMN, wanted] = positions[other, 1]
        wanted += 1
    targets[LIMIT, wanted : _padded(wanted)] = -1
    return wanted


@bare
def _remove_target(node: int, targets: Rows, wanted: int) -> int:
    """Remove a node from the targets; return the number of remaining ones."""
    at = 0
    while targets[TARGET, at] != node:
        at += 1
    for what in range(4):
        targets[what, at] = targets[what, wanted - 1]
    targets[LIMIT, wanted - 1] = -1
    return wanted - 1


@joined
def _largest_limit(targets: Rows, wanted: int) -> int:
    most = np.int32(-1)
    for i in range(wanted):
        most = max(most, targets[LIMIT, i])
    return int(most)


@joined
def _longest_useful(node: int, positions: Rows, targets: Rows, wanted: int) -> int:
    """Return the largest distance of a node with which it can still be on a witness.

    Written for SIMD with `TARGETS_A_VECTOR` 32-bit numbers per instruction: it runs for each edge.
    """
    row, column, most = positions[node, 0], positions[node, 1], np.int32(-1)
    for i in range(_padded(wanted)):
        down, right = np.int32(abs(targets[ROW, i] - row)), np.int32(abs(targets[COLUMN, i] - column))
        least = np.int32(_STRAIGHT * max(down, right)) + np.int32(_ASIDE * min(down, right))
        most = max(most, np.int32(targets[LIMIT, i] - least))
    return int(most)


@bare
def _search(
    source: int, settle: int, wanted: int, era: int, begins: Words, degrees: Integers, rows: Rows, in_round: Flags,
    positions: Rows, reached: Words, limits: Words, targets: Rows, buckets: Integers, entries: Entries,
) -> int:  # fmt: skip
    """Search witnesses to all targets; return the number of edge visits."""
    reached[source], most = era, _largest_limit(targets, wanted)
    buckets[: min(len(buckets), (most >> WIDTH) + 1)] = -1
    puts, queued, bucket, settled, work = put(buckets, entries, 0, 0, source), 1, 0, 0, np.int64(0)
    while queued > 0 and settled < settle:
        bucket = next_bucket(buckets, bucket)
        key = take(buckets, entries, bucket)
        queued -= 1
        node, length = key & LOWER, key >> 32
        if reached[node] != era + length or length > _longest_useful(node, positions, targets, wanted):
            continue
        settled += 1
        work += degrees[node]
        for at in range(begins[node], begins[node] + degrees[node]):
            further, to = length + rows[at, LENGTH_TO], rows[at, NODE]
            if further > most or era + further >= reached[to] or in_round[to]:
                continue
            # A target within its limit: witness found.
            if limits[to] < era + ERA and era + further <= limits[to]:
                limits[to] = WITNESS_FOUND
                wanted = _remove_target(to, targets, wanted)
                if wanted == 0:
                    return int(work)
                most = _largest_limit(targets, wanted)
            longest = _longest_useful(to, positions, targets, wanted)
            if further > longest:
                reached[to] = era + longest + 1  # prunes later paths as long as this one without a test
            elif puts < len(entries):
                reached[to] = era + further
                puts = put(buckets, entries, puts, further, to)
                queued += 1
    return int(work)


@bare
def _find_slot(
    batch: Integers, begins: Words, degrees: Integers, rows: Rows, in_round: Flags, positions: Rows, reached: Words,
    limits: Words, targets: Rows, buckets: Integers, entries: Entries, pairs: Integers, counts: Rows, state: Words,
    slots: int, settle: int, budget: int,
) -> None:  # fmt: skip
    work = np.int64(0)
    while state[NEXT] < len(batch) and work < budget:
        node = batch[state[NEXT]]
        degree = np.int64(degrees[node])
        if state[USED] + degree * degree > len(pairs):
            return
        found, work = state[USED], work + degree
        # One search from each neighbour to all later ones.
        for first in range(degree - 1):
            state[SEARCHES] += 1
            era = -(state[SEARCHES] * ERA)  # values of earlier searches are larger than all of this one
            wanted = _set_targets(node, first, era, begins, degrees, rows, positions, limits, targets)
            source = rows[begins[node] + first, NODE]
            visits = _search(
                source, settle, wanted, era, begins, degrees, rows, in_round, positions, reached, limits, targets,
                buckets, entries,
            )  # fmt: skip
            state[EDGE_VISITS] += visits
            work += visits
            # Pairs without a witness need a shortcut.
            for second in range(first + 1, degree):
                if limits[rows[begins[node] + second, NODE]] != WITNESS_FOUND:
                    pairs[found] = (first << PAIR_BITS) | second
                    found += 1
        counts[state[NEXT], FOUND] = found - state[USED]
        counts[state[NEXT], FIRST] = state[USED]
        counts[state[NEXT], SLOT] = state[NEXT] % slots
        state[USED] = found
        state[NEXT] += slots


@bare
def _find_serial(
    batch: Integers, begins: Words, degrees: Integers, rows: Rows, in_round: Flags, positions: Rows, reached: Heaps,
    limits: Heaps, targets: Targets, buckets: Rows, entries: Heaps, pairs: Rows, counts: Rows, states: Heaps,
    settle: int, budget: int,
) -> None:  # fmt: skip
    for slot in range(len(states)):
        _find_slot(
            batch, begins, degrees, rows, in_round, positions, reached[slot], limits[slot], targets[slot],
            buckets[slot], entries[slot], pairs[slot], counts, states[slot], len(states), settle, budget,
        )  # fmt: skip


@compiled(parallel=True)
def _find_parallel(
    batch: Integers, begins: Words, degrees: Integers, rows: Rows, in_round: Flags, positions: Rows, reached: Heaps,
    limits: Heaps, targets: Targets, buckets: Rows, entries: Heaps, pairs: Rows, counts: Rows, states: Heaps,
    settle: int, budget: int,
) -> None:  # fmt: skip
    for slot in prange(len(states)):
        _find_slot(
            batch, begins, degrees, rows, in_round, positions, reached[slot], limits[slot], targets[slot],
            buckets[slot], entries[slot], pairs[slot], counts, states[slot], len(states), settle, budget,
        )  # fmt: skip


def find_shortcuts(
    batch: Integers, begins: Words, degrees: Integers, rows: Rows, in_round: Flags, positions: Rows, reached: Heaps,
    limits: Heaps, targets: Targets, buckets: Rows, entries: Heaps, pairs: Rows, counts: Rows, states: Heaps,
    settle: int, budget: int,
    threads: int,
) -> None:  # fmt: skip
    """Examine nodes of a round until the budget of each slot is used, its pair memory is full, or all are done.

    Parameters
    ----------
    batch : (b,) int32 array
        Nodes of the round.
    begins, degrees, rows
        The graph, as in `contraction`.
    in_round : (n,) bool array
        Which nodes belong to the round.
    positions : (n, 2) int32 array
        Row and column of each node.
    reached, limits : (S, n) int64 arrays
        Scratch: distance of each node, and limit of each target, both minus the era of the search; zero at first.
    targets : (S, 4, k) int32 array
        Scratch, zero at first; k is the largest number of neighbours, rounded up to a multiple of `TARGETS_A_VECTOR`.
    buckets : (S, b) int32 array
        Scratch: bucket queue; b is a power of 2. If an edge is longer than the buckets cover, searches are slower.
    entries : (S, k, `ENTRY`) int64 array
        Scratch: entries of the queue. More entries let searches reach farther.
    pairs : (S, m) int32 array
        Out: pairs of neighbours that need a shortcut, encoded as `PAIR_BITS` describes.
    counts : (b, 3) int32 array
        Out: for each node the number of pairs `FOUND`, and the index of the first, `FIRST`, among those of its `SLOT`.
    states : (S, 4) int64 array
        State of each slot; at first the next node is i for slot i, and no pairs are written.
    settle : int
        Largest number of nodes that a search settles.
    budget : int
        Limit of the work of a slot in this call.
    threads : int
        Maximum number of threads.
    """
    with limit_threads(threads) as usable:
        kernel = _find_parallel if usable > 1 else _find_serial
        kernel(
            batch, begins, degrees, rows, in_round, positions, reached, limits, targets, buckets, entries, pairs,
            counts, states, settle, budget,
        )  # fmt: skip


def warm() -> None:
    """Compile and call each kernel once."""
    for threads in (1, 2):
        nothing, whole, wide = np.empty(0, np.int32), np.zeros((1, 3), np.int32), np.zeros((1, 1), np.int64)
        entries = np.zeros((1, 1, ENTRY), np.int64)
        targets = np.zeros((1, 4, TARGETS_A_VECTOR), np.int32)
        find_shortcuts(
            nothing, np.zeros(1, np.int64), nothing, whole, np.zeros(1, np.bool_), whole, wide, wide, targets,
            whole, entries, whole, whole.copy(), np.zeros((1, 4), np.int64), 1, 1, threads,
        )  # fmt: skip
