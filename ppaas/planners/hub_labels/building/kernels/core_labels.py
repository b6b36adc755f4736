"""Kernel: keep what searches from nodes of the core have found: it becomes labels.

A batch of nodes is searched from at a time, and none of them knew the others as hubs. So an entry is left out here if
a node of the batch that is more important tells a way as short. Then labels are those that one search after the other
would leave, and which of them lead where does not depend on how many threads searched.

A label that is full is moved to the pool's end, with room for twice as many.
"""

import numpy as np

from ppaas.planners.hub_labels.building.kernels.core_searches import FAR_OFF, HUB_OF, TOWARDS, Entries
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import FAR
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.kernels.jit_decorators import bare

FIRST_ROOM = 8

ROOT, ENTRY, POOL, LIVE = range(4)
"""What is counted in ``state``: roots of the batch that are done, entries of the next one that are, entries of the pool
in use, and entries of all labels."""


@bare
def _widen(
    node: int, hubs: Integers, lengths: Integers, edges: Integers, begins: Words, ends: Words, rooms: Integers,
    state: Words,
) -> None:  # fmt: skip
    begin, count = state[POOL], ends[node] - begins[node]
    rooms[node] = max(FIRST_ROOM, 2 * rooms[node])
    state[POOL] += rooms[node]
    for i in range(count):
        hubs[begin + i] = hubs[begins[node] + i]
        lengths[begin + i] = lengths[begins[node] + i]
        edges[begin + i] = edges[begins[node] + i]
    begins[node] = begin
    ends[node] = begin + count


@bare
def _batch_begins(node: int, first: int, hubs: Integers, begins: Words, ends: Words) -> int:
    """Return where the hubs of a label begin that are of the batch."""
    at = ends[node]
    while at > begins[node] and hubs[at - 1] >= first:
        at -= 1
    return int(at)


@bare
def _is_told(
    node: int, length: int, first: int, hubs: Integers, lengths: Integers, begins: Words, ends: Words, of_root: Integers
) -> bool:
    """Tell whether a hub of the batch tells a way as short."""
    for i in range(_batch_begins(node, first, hubs, begins, ends), ends[node]):
        if of_root[hubs[i] - first] + lengths[i] <= length:
            return True
    return False


@bare
def keep(
    first: int, batch: int, found: Entries, bounds: Words,
    hubs: Integers, lengths: Integers, edges: Integers, begins: Words, ends: Words, rooms: Integers,
    of_root: Integers, state: Words, budget: int,
) -> bool:  # fmt: skip
    """Add entries to labels until so many were looked at, or the pool is short; return whether all are done.

    Parameters
    ----------
    first, batch, found, bounds
        What `core_searches.search` found.
    hubs, lengths, edges : (m,) int32 arrays
        The pool: hub, length, and the number of the edge to go towards it, −1 if the node is the hub.
    begins, ends : int64 arrays
    rooms : (n,) int32 array
        Entries for which a label has room, 0 at first.
    of_root : (``batch``,) int32 array
        `FAR` everywhere at first.
    state : (4,) int64 array
        Zeros at first, and `ROOT` in each batch.
    budget : int
    """
    slots, work = len(found), 0
    while state[ROOT] < batch and work < budget:
        row, root = state[ROOT], first + state[ROOT]
        entries, begin, end = found[row % slots], bounds[row], bounds[row + slots]
        is_alone = True
        for i in range(_batch_begins(root, first, hubs, begins, ends), ends[root]):
            of_root[hubs[i] - first] = lengths[i]
            is_alone = False
        while begin + state[ENTRY] < end:
            at = begin + state[ENTRY]
            node, length = entries[at, HUB_OF], entries[at, FAR_OFF]
            if is_alone or not _is_told(node, length, first, hubs, lengths, begins, ends, of_root):
                if ends[node] - begins[node] == rooms[node]:
                    if state[POOL] + max(FIRST_ROOM, 2 * rooms[node]) > len(hubs):
                        return False
                    _widen(node, hubs, lengths, edges, begins, ends, rooms, state)
                hubs[ends[node]] = root
                lengths[ends[node]] = length
                edges[ends[node]] = entries[at, TOWARDS]
                ends[node] += 1
                state[LIVE] += 1
            state[ENTRY] += 1
        of_root[:] = FAR
        work += end - begin + 1
        state[ROOT] += 1
        state[ENTRY] = 0
    return bool(state[ROOT] == batch)


def warm() -> None:
    """Compile and call each kernel once."""
    nothing, far = np.empty(0, np.int32), np.zeros(1, np.int64)
    keep(
        0, 0, np.zeros((1, 1, 3), np.int32), far, nothing, nothing, nothing, far, far, nothing, nothing,
        np.zeros(4, np.int64), 0,
    )  # fmt: skip
