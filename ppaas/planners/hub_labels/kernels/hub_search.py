"""Kernel: find the hub with the shortest path between two ends, and the paths that lead to it."""

import numpy as np

from ppaas.kernel_cache.decorators import bare, joined
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.fringe_exit import write_exit_path
from ppaas.planners.hub_labels.kernels.layout import (
    CORNER_SIZE,
    CORNERS,
    ENTRIES,
    FAR,
    LABEL,
    LABELLED,
    LABELS,
    LINK_NEXT,
    LINK_PATH,
    LINK_SIZE,
    PATHS,
    TABLE,
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
from ppaas.planners.kernels.prefetch import LINE, fetch


@joined
def entries_of(table: Integers, corner: int) -> int:
    """Return the number of entries of a label."""
    return int(table[np.uint64(corner * CORNER_SIZE + ENTRIES)])


@joined
def label_of(table: Integers, corner: int) -> int:
    """Return the offset of a label."""
    return int(table[np.uint64(corner * CORNER_SIZE + LABEL)])


@joined
def _scatter(reach: Integers, labels: Integers, hubs: Shorts, begin: int, size: int, length: int) -> None:
    """Write the distances of a label into the array indexed by hub."""
    far = begin + lengths_after(size)
    for i in range(size):
        hub = np.uint64(hubs[np.uint64(2 * begin + i)])
        reach[hub] = min(reach[hub], np.int32(labels[np.uint64(far + i)] + length))


@joined
def _minimum(reach: Integers, labels: Integers, hubs: Shorts, begin: int, size: int) -> int:
    """Return the length of the path over the best hub of a label."""
    far, best = begin + lengths_after(size), np.int32(0x7FFFFFFF)
    for i in range(size):
        best = min(best, np.int32(reach[np.uint64(hubs[np.uint64(2 * begin + i)])] + labels[np.uint64(far + i)]))
    return int(best)


@joined
def _clear(reach: Integers, hubs: Shorts, begin: int, size: int) -> None:
    for i in range(size):
        reach[np.uint64(hubs[np.uint64(2 * begin + i)])] = FAR


@joined
def prefetch_label(table: Integers, labels: Integers, corner: int) -> None:
    """Prefetch the hubs and distances of the label of a corner."""
    begin = np.int64(label_of(table, corner))
    for line in range(begin, begin + np.int64(links_after(entries_of(table, corner))), LINE):
        fetch(labels, line)


@bare
def scatter_label(index: Words, scratch: Integers, corner: int, length: int) -> None:
    """Scatter the label of a corner of the start at this distance."""
    table, labels, hubs = integers_of(index, TABLE), integers_of(index, LABELS), shorts_of(index, LABELS)
    _scatter(reach_of(index, scratch), labels, hubs, label_of(table, corner), entries_of(table, corner), length)


@bare
def shortest_over(index: Words, scratch: Integers, corner: int) -> int:
    """Return the length from the start to a corner over the scattered labels; `FAR` or more without a path."""
    table, labels, hubs = integers_of(index, TABLE), integers_of(index, LABELS), shorts_of(index, LABELS)
    return int(_minimum(reach_of(index, scratch), labels, hubs, label_of(table, corner), entries_of(table, corner)))


@bare
def clear_labels(index: Words, scratch: Integers, kept: int) -> int:
    """Clear the scattered labels of the first ``kept`` corners of the start; return their number of entries."""
    table, hubs = integers_of(index, TABLE), shorts_of(index, LABELS)
    reach, visited = reach_of(index, scratch), np.int64(0)
    for rank in end_of(index, scratch, START, SEEN)[:kept]:
        corner = np.int64(rank)
        size = entries_of(table, corner)
        _clear(reach, hubs, label_of(table, corner), size)
        visited += size
    return int(visited)


@joined
def _index_of(hubs: Shorts, hub: int) -> int:
    """Return the index of a hub in a label by binary search; any index if the label does not have it."""
    low, high = 0, len(hubs) - 1
    while low < high:
        middle = (low + high) >> 1
        if hubs[middle] < hub:
            low = middle + 1
        else:
            high = middle
    return low


@bare
def _write_exit(index: Words, scratch: Integers, end: int, corner: int, length: int) -> int:
    """Write the paths from an end to a labelled corner at this distance, and return their number."""
    if index[LABELLED] < index[CORNERS]:
        return int(write_exit_path(index, scratch, end, corner, length))
    scratch[CORNER + end] = corner
    return 0


@joined
def _write_link(labels: Integers, paths: Shorts, route: Integers, place: int, link: int) -> int:
    """Write the path of a link to the route, and return the next link, or −1 after the last one."""
    path = np.int64(labels[np.uint64(link + LINK_PATH)])
    fetch(paths, path)
    route[np.uint64(place)] = path
    return int(labels[np.uint64(link + LINK_NEXT)])


@bare
def _write_links(index: Words, scratch: Integers, link: int, count: int, to_link: int, to_count: int) -> None:
    """Write the paths from both ends to the hub, given the links to it and the numbers of paths written so far.

    Each link is far from the previous one in memory, so the links of both ends are read alternately.
    """
    labels, paths, route = integers_of(index, LABELS), shorts_of(index, PATHS), route_of(index, scratch)
    last = len(route) - 1
    if labels[link + LINK_PATH] < 0:
        link = -1
    if labels[to_link + LINK_PATH] < 0:
        to_link = -1
    while link >= 0 or to_link >= 0:
        if link >= 0:
            link = int(_write_link(labels, paths, route, count, link))
            count += 1
        if to_link >= 0:
            to_link = int(_write_link(labels, paths, route, last - to_count, to_link))
            to_count += 1
    scratch[COUNT + START] = count
    scratch[COUNT + GOAL] = to_count


@bare
def write_route(index: Words, scratch: Integers, kept: int, to_corner: int, to_length: int, length: int) -> None:
    """Write the route of this length from a scattered corner to a corner at distance ``to_length`` from the goal."""
    table, labels, hubs = integers_of(index, TABLE), integers_of(index, LABELS), shorts_of(index, LABELS)
    reach = reach_of(index, scratch)
    seen, lengths = end_of(index, scratch, START, SEEN), end_of(index, scratch, START, LENGTHS)
    begin, size = label_of(table, to_corner), entries_of(table, to_corner)
    far, place = begin + lengths_after(size), 0
    # Best hub of the label of the goal's corner.
    while reach[hubs[2 * begin + place]] + labels[far + place] != length:
        place += 1
    hub = hubs[2 * begin + place]
    to_link = np.int64(begin + links_after(size) + LINK_SIZE * place)
    fetch(labels, to_link)
    # Corner of the start that gave the hub its distance.
    for i in range(kept):
        corner = np.int64(seen[i])
        begin, size = label_of(table, corner), entries_of(table, corner)
        place = _index_of(hubs[2 * begin : 2 * begin + size], hub)
        found = hubs[2 * begin + place] == hub
        if found and labels[begin + lengths_after(size) + place] + lengths[i] == reach[hub]:
            link = np.int64(begin + links_after(size) + LINK_SIZE * place)
            fetch(labels, link)
            to_count = np.int64(_write_exit(index, scratch, GOAL, to_corner, to_length))
            count = np.int64(_write_exit(index, scratch, START, corner, np.int64(lengths[i])))
            _write_links(index, scratch, link, count, to_link, to_count)
            return
