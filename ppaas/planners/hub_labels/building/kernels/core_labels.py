"""Kernel: add the results of core searches to labels.

Nodes of a batch are searched in parallel and do not know each other as hubs. So an entry is dropped here if a more
important node of the batch covers it with a path as short. The labels equal those of sequential searches, and do not
depend on the number of threads.

A full label moves to the end of the pool, with twice the capacity.
"""

import numpy as np

from ppaas.kernel_cache.decorators import bare
from ppaas.planners.hub_labels.building.kernels.core_searches import HUB_OF, LENGTH, TOWARDS, Entries
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import FAR
from ppaas.planners.hub_labels.kernels.scan import Integers

FIRST_CAPACITY = 8
"""Initial capacity of a label [entries]."""

ROOT, ENTRY, POOL, LIVE = range(4)
"""Counters in ``state``: finished roots of the batch, finished entries of the next root, pool entries in use, and
entries of all labels."""


@bare
def _enlarge(
    node: int, hubs: Integers, lengths: Integers, edges: Integers, begins: Words, ends: Words, capacities: Integers,
    state: Words,
) -> None:  # fmt: skip
    """Move a label to the end of the pool, with twice the capacity."""
    begin, count = state[POOL], ends[node] - begins[node]
    capacities[node] = max(FIRST_CAPACITY, 2 * capacities[node])
    state[POOL] += capacities[node]
    for i in range(count):
        hubs[begin + i] = hubs[begins[node] + i]
        lengths[begin + i] = lengths[begins[node] + i]
        edges[begin + i] = edges[begins[node] + i]
    begins[node] = begin
    ends[node] = begin + count


@bare
def _batch_begins(node: int, first: int, hubs: Integers, begins: Words, ends: Words) -> int:
    """Return the index of the first hub of a label that belongs to the batch."""
    at = ends[node]
    while at > begins[node] and hubs[at - 1] >= first:
        at -= 1
    return int(at)


@bare
def _is_covered(
    node: int,
    length: int,
    first: int,
    hubs: Integers,
    lengths: Integers,
    begins: Words,
    ends: Words,
    from_root: Integers,
) -> bool:
    """Return whether a path over a hub of the batch is as short."""
    for i in range(_batch_begins(node, first, hubs, begins, ends), ends[node]):
        if from_root[hubs[i] - first] + lengths[i] <= length:
            return True
    return False


@bare
def add_entries(
    first: int, batch: int, found: Entries, bounds: Words,
    hubs: Integers, lengths: Integers, edges: Integers, begins: Words, ends: Words, capacities: Integers,
    from_root: Integers, state: Words, budget: int,
) -> bool:  # fmt: skip
    """Add entries to labels until the budget is used or the pool is full; return whether all are done.

    Parameters
    ----------
    first, batch, found, bounds
        Results of `core_searches.search`.
    hubs, lengths, edges : (m,) int32 arrays
        The pool: hub, distance, and edge towards the hub, −1 for the hub itself.
    begins, ends : (n,) int64 arrays
        Range of each label in the pool.
    capacities : (n,) int32 array
        Capacity of each label, zero at first.
    from_root : (``batch``,) int32 array
        Scratch: distances of hubs of the batch from the root; `FAR` at first.
    state : (4,) int64 array
        Counters, zero at first; `ROOT` is zero at the begin of each batch.
    budget : int
        Limit of the work in this call.
    """
    slots, work = len(found), 0
    while state[ROOT] < batch and work < budget:
        row, root = state[ROOT], first + state[ROOT]
        entries, begin, end = found[row % slots], bounds[row], bounds[row + slots]
        is_alone = True
        for i in range(_batch_begins(root, first, hubs, begins, ends), ends[root]):
            from_root[hubs[i] - first] = lengths[i]
            is_alone = False
        while begin + state[ENTRY] < end:
            at = begin + state[ENTRY]
            node, length = entries[at, HUB_OF], entries[at, LENGTH]
            if is_alone or not _is_covered(node, length, first, hubs, lengths, begins, ends, from_root):
                if ends[node] - begins[node] == capacities[node]:
                    if state[POOL] + max(FIRST_CAPACITY, 2 * capacities[node]) > len(hubs):
                        return False
                    _enlarge(node, hubs, lengths, edges, begins, ends, capacities, state)
                hubs[ends[node]] = root
                lengths[ends[node]] = length
                edges[ends[node]] = entries[at, TOWARDS]
                ends[node] += 1
                state[LIVE] += 1
            state[ENTRY] += 1
        from_root[:] = FAR
        work += end - begin + 1
        state[ROOT] += 1
        state[ENTRY] = 0
    return bool(state[ROOT] == batch)


def warm() -> None:
    """Compile and call each kernel once."""
    nothing, far = np.empty(0, np.int32), np.zeros(1, np.int64)
    add_entries(
        0, 0, np.zeros((1, 1, 3), np.int32), far, nothing, nothing, nothing, far, far, nothing, nothing,
        np.zeros(4, np.int64), 0,
    )  # fmt: skip
