"""Kernel: tell what shortcuts a contracted node leaves, for all nodes of a round, on all cores, in slices.

From each neighbour of a node all its others are looked for over ways that avoid the nodes of the round. A way is
followed only as long as it may still be as short as that over the node, to some neighbour that is not found yet: it is
known how far apart two places are at least. That is asked again when its turn comes, as fewer may be left to find by
then.

Each *slot* looks at nodes of its own: slot s of S at the nodes s, s + S, s + 2 S … of the round.
"""

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from ppaas.kernel_threads import at_most
from ppaas.planners.hub_labels.building.kernels.bucket_queue import ENTRY, WIDTH, Entries, next_bucket, put, take
from ppaas.planners.hub_labels.building.kernels.contraction import FAR_OFF, FIRST, FOUND, NODE, PAIR_BITS, SLOT, Flags
from ppaas.planners.hub_labels.building.kernels.trees import Heaps, Rows
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.heap import NODE as LOWER
from ppaas.planners.hub_labels.kernels.scan import DIAGONAL, STRAIGHT, Integers
from ppaas.planners.kernels.jit_decorators import bare, joined

Targets = NDArray[np.int32]

NEXT, USED, SEARCHES, SCANS = range(4)
"""What a slot knows of its work: its next node, how many pairs it has told, and how often it has searched so far and at
how many edges it has looked."""

ERA = 1 << 32
"""What is written by one search lies so far from that of the next."""

WANTED, LIMIT, ROW, COLUMN = range(4)
"""Of what is looked for: which node, how far it may be over another way, and its place."""

SATISFIED = np.iinfo(np.int64).max
"""Stands for the limit of a node to which a way was found."""

AT_A_TIME = 16
"""Targets are filled up to a multiple of so many, by some to which no way leads."""

_STRAIGHT, _ASIDE = np.int32(STRAIGHT), np.int32(DIAGONAL - STRAIGHT)


@joined
def _padded(wanted: int) -> int:
    return -(-wanted // AT_A_TIME) * AT_A_TIME


@bare
def _aim(
    node: int, first: int, era: int, begins: Words, degrees: Integers, rows: Rows, places: Rows, limits: Words,
    targets: Rows,
) -> int:  # fmt: skip
    """Write to which neighbours other ways are looked for from one, and how long they may be; return how many."""
    begin, own = begins[node], np.int64(rows[begins[node] + first, FAR_OFF])
    wanted = 0
    for at in range(begin + first + 1, begin + degrees[node]):
        other, limit = rows[at, NODE], own + rows[at, FAR_OFF]
        limits[other] = era + limit
        targets[WANTED, wanted] = other
        targets[LIMIT, wanted] = limit
        targets[ROW, wanted] = places[other, 0]
        targets[COLUMN, wanted] = places[other, 1]
        wanted += 1
    targets[LIMIT, wanted : _padded(wanted)] = -1
    return wanted


@bare
def _strike(node: int, targets: Rows, wanted: int) -> int:
    """Take a node out of those that are looked for; return how many are left."""
    at = 0
    while targets[WANTED, at] != node:
        at += 1
    for what in range(4):
        targets[what, at] = targets[what, wanted - 1]
    targets[LIMIT, wanted - 1] = -1
    return wanted - 1


@joined
def _farthest(targets: Rows, wanted: int) -> int:
    most = np.int32(-1)
    for i in range(wanted):
        most = max(most, targets[LIMIT, i])
    return int(most)


@joined
def _longest(node: int, places: Rows, targets: Rows, wanted: int) -> int:
    """Return how long a way to a node may be if it is to lead on to some node that is looked for.

    Written for `AT_A_TIME` numbers of 32 bits to be looked at by each instruction: it is asked for each edge.
    """
    row, column, most = places[node, 0], places[node, 1], np.int32(-1)
    for i in range(_padded(wanted)):
        down, right = np.int32(abs(targets[ROW, i] - row)), np.int32(abs(targets[COLUMN, i] - column))
        least = np.int32(_STRAIGHT * max(down, right)) + np.int32(_ASIDE * min(down, right))
        most = max(most, np.int32(targets[LIMIT, i] - least))
    return int(most)


@bare
def _search(
    source: int, settle: int, wanted: int, era: int, begins: Words, degrees: Integers, rows: Rows, held: Flags,
    places: Rows, reached: Words, limits: Words, targets: Rows, buckets: Integers, entries: Entries,
) -> int:  # fmt: skip
    """Look for ways to all that are wanted; return at how many edges it looked."""
    reached[source], most = era, _farthest(targets, wanted)
    buckets[: min(len(buckets), (most >> WIDTH) + 1)] = -1
    puts, queued, bucket, settled, work = put(buckets, entries, 0, 0, source), 1, 0, 0, np.int64(0)
    while queued > 0 and settled < settle:
        bucket = next_bucket(buckets, bucket)
        key = take(buckets, entries, bucket)
        queued -= 1
        node, length = key & LOWER, key >> 32
        if reached[node] != era + length or length > _longest(node, places, targets, wanted):
            continue
        settled += 1
        work += degrees[node]
        for at in range(begins[node], begins[node] + degrees[node]):
            further, to = length + rows[at, FAR_OFF], rows[at, NODE]
            if further > most or era + further >= reached[to] or held[to]:
                continue
            if limits[to] < era + ERA and era + further <= limits[to]:
                limits[to] = SATISFIED
                wanted = _strike(to, targets, wanted)
                if wanted == 0:
                    return int(work)
                most = _farthest(targets, wanted)
            longest = _longest(to, places, targets, wanted)
            if further > longest:
                reached[to] = era + longest + 1  # whoever comes there by a way as long need not ask
            elif puts < len(entries):
                reached[to] = era + further
                puts = put(buckets, entries, puts, further, to)
                queued += 1
    return int(work)


@bare
def _find_slot(
    batch: Integers, begins: Words, degrees: Integers, rows: Rows, held: Flags, places: Rows, reached: Words,
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
        for first in range(degree - 1):
            state[SEARCHES] += 1
            era = -(state[SEARCHES] * ERA)  # what an earlier search wrote is larger than all of this one
            wanted = _aim(node, first, era, begins, degrees, rows, places, limits, targets)
            source = rows[begins[node] + first, NODE]
            looks = _search(
                source, settle, wanted, era, begins, degrees, rows, held, places, reached, limits, targets,
                buckets, entries,
            )  # fmt: skip
            state[SCANS] += looks
            work += looks
            for second in range(first + 1, degree):
                if limits[rows[begins[node] + second, NODE]] != SATISFIED:
                    pairs[found] = (first << PAIR_BITS) | second
                    found += 1
        counts[state[NEXT], FOUND] = found - state[USED]
        counts[state[NEXT], FIRST] = state[USED]
        counts[state[NEXT], SLOT] = state[NEXT] % slots
        state[USED] = found
        state[NEXT] += slots


@bare
def _find_serial(
    batch: Integers, begins: Words, degrees: Integers, rows: Rows, held: Flags, places: Rows, reached: Heaps,
    limits: Heaps, targets: Targets, buckets: Rows, entries: Heaps, pairs: Rows, counts: Rows, states: Heaps,
    settle: int, budget: int,
) -> None:  # fmt: skip
    for slot in range(len(states)):
        _find_slot(
            batch, begins, degrees, rows, held, places, reached[slot], limits[slot], targets[slot],
            buckets[slot], entries[slot], pairs[slot], counts, states[slot], len(states), settle, budget,
        )  # fmt: skip


@njit(cache=True, nogil=True, error_model="numpy", parallel=True)
def _find_parallel(
    batch: Integers, begins: Words, degrees: Integers, rows: Rows, held: Flags, places: Rows, reached: Heaps,
    limits: Heaps, targets: Targets, buckets: Rows, entries: Heaps, pairs: Rows, counts: Rows, states: Heaps,
    settle: int, budget: int,
) -> None:  # fmt: skip
    for slot in prange(len(states)):
        _find_slot(
            batch, begins, degrees, rows, held, places, reached[slot], limits[slot], targets[slot],
            buckets[slot], entries[slot], pairs[slot], counts, states[slot], len(states), settle, budget,
        )  # fmt: skip


def find_shortcuts(
    batch: Integers, begins: Words, degrees: Integers, rows: Rows, held: Flags, places: Rows, reached: Heaps,
    limits: Heaps, targets: Targets, buckets: Rows, entries: Heaps, pairs: Rows, counts: Rows, states: Heaps,
    settle: int, budget: int,
    threads: int,
) -> None:  # fmt: skip
    """Look at nodes of a round until each slot has looked at so many edges, or has no room, or all is done.

    Parameters
    ----------
    batch : (b,) int32 array
        The nodes.
    begins, degrees, rows
        The graph, as `contraction` has it.
    held : (n,) bool array
        Which nodes belong to the round.
    places : (n, 2) int32 array
        Row and column of each node.
    reached, limits : (S, n) int64 arrays
        Zeros at first; how far a node is and may be, both less than in all searches before.
    targets : (S, 4, k) int32 array
        Zeros at first; for as many nodes as a node of the round has neighbours, a multiple of `AT_A_TIME`.
    buckets : (S, b) int32 array
        Scratch, 2 to the power of something. Edges that are longer than they go round make it take longer.
    entries : (S, k, `ENTRY`) int64 array
        Scratch; the longer, the further searches go.
    pairs : (S, m) int32 array
        Out: pairs of places in the row of a node; they are told by `PAIR_BITS`.
    counts : (b, 3) int32 array
        Out: how many pairs each node has, `FOUND`, and where they begin, `FIRST`, among those of its `SLOT`.
    states : (S, 4) int64 array
        Slot i has the next node i and no pairs at first.
    settle : int
        Nodes that a search for another way may settle.
    budget, threads : int
    """
    with at_most(threads) as usable:
        kernel = _find_parallel if usable > 1 else _find_serial
        kernel(
            batch, begins, degrees, rows, held, places, reached, limits, targets, buckets, entries, pairs, counts,
            states, settle, budget,
        )  # fmt: skip


def warm() -> None:
    """Compile and call each kernel once."""
    for threads in (1, 2):
        nothing, whole, wide = np.empty(0, np.int32), np.zeros((1, 3), np.int32), np.zeros((1, 1), np.int64)
        entries = np.zeros((1, 1, ENTRY), np.int64)
        targets = np.zeros((1, 4, AT_A_TIME), np.int32)
        find_shortcuts(
            nothing, np.zeros(1, np.int64), nothing, whole, np.zeros(1, np.bool_), whole, wide, wide, targets,
            whole, entries, whole, whole.copy(), np.zeros((1, 4), np.int64), 1, 1, threads,
        )  # fmt: skip
