"""Kernel: find the hub over which the way between two ends is shortest, and the ways that lead to it."""

import numpy as np

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.fringe_exit import pass_gates
from ppaas.planners.hub_labels.kernels.layout import (
    CORNER_SIZE,
    CORNERS,
    ENTRIES,
    FAR,
    LABEL,
    LABELLED,
    LABELS,
    LINK_NEXT,
    LINK_SIZE,
    LINK_WAY,
    TABLE,
    WAYS,
    Shorts,
    integers_of,
    lengths_after,
    links_after,
    shorts_of,
)
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.hub_labels.kernels.scratch import (
    CORNER,
    COUNT,
    GOAL,
    LENGTHS,
    SEEN,
    START,
    end_of,
    reach_of,
    route_of,
)
from ppaas.planners.kernels.jit_decorators import bare, joined
from ppaas.planners.kernels.prefetch import LINE, fetch


@joined
def entries_of(table: Integers, corner: int) -> int:
    """Return how many entries a label has."""
    return int(table[np.uint64(corner * CORNER_SIZE + ENTRIES)])


@joined
def label_of(table: Integers, corner: int) -> int:
    """Return where a label lies."""
    return int(table[np.uint64(corner * CORNER_SIZE + LABEL)])


@joined
def _lay_entries(reach: Integers, labels: Integers, hubs: Shorts, begin: int, size: int, length: int) -> None:
    """Lay a label out by its hubs."""
    far = begin + lengths_after(size)
    for i in range(size):
        hub = np.uint64(hubs[np.uint64(2 * begin + i)])
        reach[hub] = min(reach[hub], np.int32(labels[np.uint64(far + i)] + length))


@joined
def _least(reach: Integers, labels: Integers, hubs: Shorts, begin: int, size: int) -> int:
    """Return how long the way over the best hub of a label is."""
    far, best = begin + lengths_after(size), np.int32(0x7FFFFFFF)
    for i in range(size):
        best = min(best, np.int32(reach[np.uint64(hubs[np.uint64(2 * begin + i)])] + labels[np.uint64(far + i)]))
    return int(best)


@joined
def _clear(reach: Integers, hubs: Shorts, begin: int, size: int) -> None:
    for i in range(size):
        reach[np.uint64(hubs[np.uint64(2 * begin + i)])] = FAR


@joined
def announce(table: Integers, labels: Integers, corner: int) -> None:
    """Begin to bring the label of a corner, as far as lengths go."""
    begin = np.int64(label_of(table, corner))
    for line in range(begin, begin + np.int64(links_after(entries_of(table, corner))), LINE):
        fetch(labels, line)


@bare
def lay_out(index: Words, scratch: Integers, corner: int, length: int) -> None:
    """Lay the label of a corner of the start out, which is so far from it."""
    table, labels, hubs = integers_of(index, TABLE), integers_of(index, LABELS), shorts_of(index, LABELS)
    _lay_entries(reach_of(index, scratch), labels, hubs, label_of(table, corner), entries_of(table, corner), length)


@bare
def look_up(index: Words, scratch: Integers, corner: int) -> int:
    """Return how long the way from the start to a corner is, over what was laid out; `FAR` or more without one."""
    table, labels, hubs = integers_of(index, TABLE), integers_of(index, LABELS), shorts_of(index, LABELS)
    return int(_least(reach_of(index, scratch), labels, hubs, label_of(table, corner), entries_of(table, corner)))


@bare
def take_back(index: Words, scratch: Integers, kept: int) -> int:
    """Forget what was laid out of the first so many corners of the start; return how many entries they have."""
    table, hubs = integers_of(index, TABLE), shorts_of(index, LABELS)
    reach, looked = reach_of(index, scratch), np.int64(0)
    for rank in end_of(index, scratch, START, SEEN)[:kept]:
        corner = np.int64(rank)
        size = entries_of(table, corner)
        _clear(reach, hubs, label_of(table, corner), size)
        looked += size
    return int(looked)


@joined
def _place_of(hubs: Shorts, hub: int) -> int:
    """Return where a hub is in a label; any place if it is not in it."""
    low, high = 0, len(hubs) - 1
    while low < high:
        middle = (low + high) >> 1
        if hubs[middle] < hub:
            low = middle + 1
        else:
            high = middle
    return low


@bare
def _set_out(index: Words, scratch: Integers, end: int, corner: int, length: int) -> int:
    """Write the ways from an end to a corner that is so far from it, and return how many they are."""
    if index[LABELLED] < index[CORNERS]:
        return int(pass_gates(index, scratch, end, corner, length))
    scratch[CORNER + end] = corner
    return 0


@joined
def _follow(labels: Integers, ways: Shorts, route: Integers, place: int, link: int) -> int:
    """Write the way of a link to a place of the route, and return the next link; −1 if it was the last."""
    way = np.int64(labels[np.uint64(link + LINK_WAY)])
    fetch(ways, way)
    route[np.uint64(place)] = way
    return int(labels[np.uint64(link + LINK_NEXT)])


@bare
def _meet(index: Words, scratch: Integers, link: int, count: int, to_link: int, to_count: int) -> None:
    """Write the ways from both ends to the hub, given the links to it and how many ways were written before.

    Each link lies far from the one before, so those of the two ends are looked at in turns.
    """
    labels, ways, route = integers_of(index, LABELS), shorts_of(index, WAYS), route_of(index, scratch)
    last = len(route) - 1
    if labels[link + LINK_WAY] < 0:
        link = -1
    if labels[to_link + LINK_WAY] < 0:
        to_link = -1
    while link >= 0 or to_link >= 0:
        if link >= 0:
            link = int(_follow(labels, ways, route, count, link))
            count += 1
        if to_link >= 0:
            to_link = int(_follow(labels, ways, route, last - to_count, to_link))
            to_count += 1
    scratch[COUNT + START] = count
    scratch[COUNT + GOAL] = to_count


@bare
def walk(index: Words, scratch: Integers, kept: int, to_corner: int, to_length: int, length: int) -> None:
    """Write the route of that length from one of the corners laid out to a corner that is so far from the goal."""
    table, labels, hubs = integers_of(index, TABLE), integers_of(index, LABELS), shorts_of(index, LABELS)
    reach = reach_of(index, scratch)
    seen, lengths = end_of(index, scratch, START, SEEN), end_of(index, scratch, START, LENGTHS)
    begin, size = label_of(table, to_corner), entries_of(table, to_corner)
    far, place = begin + lengths_after(size), 0
    while reach[hubs[2 * begin + place]] + labels[far + place] != length:
        place += 1
    hub = hubs[2 * begin + place]
    to_link = np.int64(begin + links_after(size) + LINK_SIZE * place)
    fetch(labels, to_link)
    for i in range(kept):
        corner = np.int64(seen[i])
        begin, size = label_of(table, corner), entries_of(table, corner)
        place = _place_of(hubs[2 * begin : 2 * begin + size], hub)
        found = hubs[2 * begin + place] == hub
        if found and labels[begin + lengths_after(size) + place] + lengths[i] == reach[hub]:
            link = np.int64(begin + links_after(size) + LINK_SIZE * place)
            fetch(labels, link)
            to_count = np.int64(_set_out(index, scratch, GOAL, to_corner, to_length))
            count = np.int64(_set_out(index, scratch, START, corner, np.int64(lengths[i])))
            _meet(index, scratch, link, count, to_link, to_count)
            return
