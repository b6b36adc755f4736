"""Kernel: leave the fringe through the gates of the corners that an end sees."""

import numpy as np

from ppaas.kernel_cache.decorators import bare, joined
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
    PATHS,
    TABLE,
    edges_after,
    integers_of,
    shorts_of,
)
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.hub_labels.kernels.scratch import (
    CORNER,
    LENGTHS,
    NEAR,
    NEAR_LENGTHS,
    SEEN,
    end_of,
    reach_of,
    route_of,
    side_of,
)
from ppaas.planners.kernels.prefetch import LINE, fetch

HUB = (1 << HUB_BITS) - 1
"""Mask of the hub in a gate."""


@joined
def _offer(hub: int, length: int, reach: Integers, seen: Integers, count: int) -> int:
    # New hubs are unpredictable, so there is no branch. If all hubs are in the list, the write past its end hits the
    # first of the lengths, which are written later.
    before = reach[np.uint64(hub)]
    reach[np.uint64(hub)] = min(before, np.int32(length))
    seen[np.uint64(count)] = hub
    return count + int(before == FAR)


@bare
def save_visible(index: Words, scratch: Integers, end: int, found: int) -> None:
    """Save the corners that an end sees, and prefetch their labels."""
    table, labels = integers_of(index, TABLE), integers_of(index, LABELS)
    seen, lengths = end_of(index, scratch, end, SEEN), end_of(index, scratch, end, LENGTHS)
    near, far = end_of(index, scratch, end, NEAR), end_of(index, scratch, end, NEAR_LENGTHS)
    for i in range(found):
        near[i], far[i] = seen[i], lengths[i]
        for line in range(3):
            fetch(labels, np.int64(table[near[i] * CORNER_SIZE + LABEL]) + LINE * line)


@bare
def exit_fringe(index: Words, scratch: Integers, end: int, found: int) -> int:
    """Find the labelled corners through which paths from an end leave the fringe, and return their number."""
    table, labels, labelled = integers_of(index, TABLE), integers_of(index, LABELS), index[LABELLED]
    seen, lengths = end_of(index, scratch, end, SEEN), end_of(index, scratch, end, LENGTHS)
    near, far = end_of(index, scratch, end, NEAR), end_of(index, scratch, end, NEAR_LENGTHS)
    reach, count = reach_of(index, scratch), np.int64(0)
    landmarks, marks = integers_of(index, LANDMARKS), np.int64(index[LANDMARK_COUNT])
    # Distance of each labelled corner over gates.
    for i in range(found):
        corner, far_off = np.int64(near[i]), np.int64(far[i])
        if corner < labelled:
            count = np.int64(_offer(corner, far_off, reach, seen, count))
            continue
        begin = np.int64(table[corner * CORNER_SIZE + LABEL])
        gates = np.int64(labels[begin + GATE_COUNT])
        for at in range(begin + FRINGE_HEAD, begin + FRINGE_HEAD + gates):
            hub, length = np.int64(labels[np.uint64(at)]) & HUB, far_off + labels[np.uint64(at + gates)]
            count = np.int64(_offer(hub, length, reach, seen, count))
    # Collect the distances, and reset the array.
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
    """Return the index of a hub among the gates of a fringe corner, or −1."""
    for gate in range(labels[begin + GATE_COUNT]):
        if np.int64(labels[begin + FRINGE_HEAD + gate]) & HUB == hub:
            return int(gate)
    return -1


@bare
def _first_corner(index: Words, scratch: Integers, end: int, hub: int, length: int) -> int:
    """Return the corner that an end sees through which a hub has this distance."""
    table, labels, labelled = integers_of(index, TABLE), integers_of(index, LABELS), index[LABELLED]
    near, far = end_of(index, scratch, end, NEAR), end_of(index, scratch, end, NEAR_LENGTHS)
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
def write_exit_path(index: Words, scratch: Integers, end: int, hub: int, length: int) -> int:
    """Write the paths from an end to a hub at this distance to the route, and return their number.

    The first corner after the end is stored in the scratch memory.
    """
    table, labels, labelled = integers_of(index, TABLE), integers_of(index, LABELS), index[LABELLED]
    paths, route = shorts_of(index, PATHS), route_of(index, scratch)
    first, step = side_of(route, end)
    corner, count = np.int64(_first_corner(index, scratch, end, hub, length)), np.int64(0)
    scratch[CORNER + end] = corner
    while corner >= labelled:
        begin, edges = np.int64(table[corner * CORNER_SIZE + LABEL]), -1 - table[corner * CORNER_SIZE + ENTRIES]
        for line in range(1, 5):
            fetch(labels, begin + LINE * line)
        edge = begin + edges_after(labels[begin + GATE_COUNT])
        edge += labels[begin + FRINGE_HEAD + _gate_of(labels, begin, hub)] >> HUB_BITS
        path = np.int64(labels[edge + 2 * edges])
        fetch(paths, path)
        route[first + step * count] = path
        count += 1
        corner = np.int64(labels[edge])
    return int(count)
