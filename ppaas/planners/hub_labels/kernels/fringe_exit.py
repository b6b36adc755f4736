"""Kernel: leave the fringe from the corners that an end sees, over their gates."""

import numpy as np

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import (
    CORNER_SIZE,
    ENTRIES,
    FAR,
    FRINGE_HEAD,
    GATE_COUNT,
    HUB_BITS,
    LABEL,
    LABELLED,
    LABELS,
    LANDMARK_COUNT,
    LANDMARKS,
    TABLE,
    WAYS,
    edges_after,
    integers_of,
    shorts_of,
)
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.hub_labels.kernels.scratch import (
    CORNER,
    JOINED,
    JOINED_LENGTHS,
    LENGTHS,
    SEEN,
    end_of,
    reach_of,
    route_of,
    side_of,
)
from ppaas.planners.kernels.jit_decorators import bare, joined
from ppaas.planners.kernels.prefetch import LINE, fetch

HUB = (1 << HUB_BITS) - 1


@joined
def _reach(hub: int, length: int, reach: Integers, seen: Integers, count: int) -> int:
    # Which hubs are new nobody can foretell, so there is no branch. Where all are known, what is written behind the
    # list is the first of the lengths, which come when the list is whole.
    before = reach[np.uint64(hub)]
    reach[np.uint64(hub)] = min(before, np.int32(length))
    seen[np.uint64(count)] = hub
    return count + int(before == FAR)


@bare
def keep(index: Words, scratch: Integers, end: int, found: int) -> None:
    """Keep the corners aside that an end sees, and begin to bring what is told of them."""
    table, labels = integers_of(index, TABLE), integers_of(index, LABELS)
    seen, lengths = end_of(index, scratch, end, SEEN), end_of(index, scratch, end, LENGTHS)
    near, far = end_of(index, scratch, end, JOINED), end_of(index, scratch, end, JOINED_LENGTHS)
    for i in range(found):
        near[i], far[i] = seen[i], lengths[i]
        for line in range(3):
            fetch(labels, np.int64(table[near[i] * CORNER_SIZE + LABEL]) + LINE * line)


@bare
def leave(index: Words, scratch: Integers, end: int, found: int) -> int:
    """Find the corners with labels over which ways leave the fringe from what an end sees, and return how many."""
    table, labels, labelled = integers_of(index, TABLE), integers_of(index, LABELS), index[LABELLED]
    seen, lengths = end_of(index, scratch, end, SEEN), end_of(index, scratch, end, LENGTHS)
    near, far = end_of(index, scratch, end, JOINED), end_of(index, scratch, end, JOINED_LENGTHS)
    reach, count = reach_of(index, scratch), np.int64(0)
    landmarks, marks = integers_of(index, LANDMARKS), np.int64(index[LANDMARK_COUNT])
    for i in range(found):
        corner, beyond = np.int64(near[i]), np.int64(far[i])
        if corner < labelled:
            count = np.int64(_reach(corner, beyond, reach, seen, count))
            continue
        begin = np.int64(table[corner * CORNER_SIZE + LABEL])
        gates = np.int64(labels[begin + GATE_COUNT])
        for at in range(begin + FRINGE_HEAD, begin + FRINGE_HEAD + gates):
            hub, length = np.int64(labels[np.uint64(at)]) & HUB, beyond + labels[np.uint64(at + gates)]
            count = np.int64(_reach(hub, length, reach, seen, count))
    for i in range(count):
        hub = np.int64(seen[i])
        lengths[i] = reach[np.uint64(hub)]
        reach[np.uint64(hub)] = FAR
        fetch(table, hub * CORNER_SIZE)
        fetch(landmarks, hub * marks)
        fetch(landmarks, hub * marks + LINE)
    return int(count)


@bare
def _gate_of(labels: Integers, begin: int, hub: int) -> int:
    """Return which of the gates of a corner of the fringe a hub is, or −1."""
    for gate in range(labels[begin + GATE_COUNT]):
        if np.int64(labels[begin + FRINGE_HEAD + gate]) & HUB == hub:
            return int(gate)
    return -1


@bare
def _first(index: Words, scratch: Integers, end: int, hub: int, length: int) -> int:
    """Return the corner next to an end over which a hub is so far from it."""
    table, labels, labelled = integers_of(index, TABLE), integers_of(index, LABELS), index[LABELLED]
    near, far = end_of(index, scratch, end, JOINED), end_of(index, scratch, end, JOINED_LENGTHS)
    i = 0
    while True:
        corner, rest = np.int64(near[i]), length - far[i]
        if corner < labelled:
            if corner == hub and rest == 0:
                return int(corner)
        else:
            begin = np.int64(table[corner * CORNER_SIZE + LABEL])
            gate = _gate_of(labels, begin, hub)
            if gate >= 0 and labels[begin + FRINGE_HEAD + labels[begin + GATE_COUNT] + gate] == rest:
                return int(corner)
        i += 1


@bare
def pass_gates(index: Words, scratch: Integers, end: int, hub: int, length: int) -> int:
    """Write the ways from an end to a hub that is so far from it to the route, and return how many they are.

    The corner next to the end is told in the scratch.
    """
    table, labels, labelled = integers_of(index, TABLE), integers_of(index, LABELS), index[LABELLED]
    ways, route = shorts_of(index, WAYS), route_of(index, scratch)
    first, step = side_of(route, end)
    corner, count = np.int64(_first(index, scratch, end, hub, length)), np.int64(0)
    scratch[CORNER + end] = corner
    while corner >= labelled:
        begin, edges = np.int64(table[corner * CORNER_SIZE + LABEL]), -1 - table[corner * CORNER_SIZE + ENTRIES]
        for line in range(1, 5):
            fetch(labels, begin + LINE * line)
        edge = begin + edges_after(labels[begin + GATE_COUNT])
        edge += labels[begin + FRINGE_HEAD + _gate_of(labels, begin, hub)] >> HUB_BITS
        way = np.int64(labels[edge + 2 * edges])
        fetch(ways, way)
        route[first + step * count] = way
        count += 1
        corner = np.int64(labels[edge])
    return int(count)
