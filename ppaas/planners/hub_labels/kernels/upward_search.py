"""Kernel: path between two ends that uses no labelled corner: upward searches from both until they meet.

Fringe corners have edges to more important corners only. The shortest path between two corners goes up from both to a
common corner (Geisberger, Sanders, Schultes and Delling, "Contraction Hierarchies", WEA 2008). The search is limited to
local edges and to paths shorter than the best one over labels. It is skipped if the rectangles that both ends reach do
not intersect. Corners are expanded from the least important up, so each is expanded once.
"""

import numpy as np

from ppaas.kernel_cache.decorators import bare, joined
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.heap import NODE, pop, push
from ppaas.planners.hub_labels.kernels.joining import lower_bound_between
from ppaas.planners.hub_labels.kernels.layout import (
    BOTTOM,
    COLUMN,
    CORNER_SIZE,
    CORNERS,
    ENTRIES,
    FAR,
    GATE_COUNT,
    LABEL,
    LABELLED,
    LABELS,
    LANDMARK_COUNT,
    LEFTMOST,
    RIGHTMOST,
    ROW,
    TABLE,
    TOP,
    edges_after,
    integers_of,
)
from ppaas.planners.hub_labels.kernels.scan import Integers, octile
from ppaas.planners.hub_labels.kernels.scratch import (
    CORNER,
    GOAL,
    LENGTH_SO_FAR,
    NEAR,
    NEAR_LENGTHS,
    PARENT,
    PATH_TO,
    REACHED,
    RECORD,
    START,
    TOUCHED,
    end_of,
    fringe_of,
    heap_of,
    route_of,
    side_of,
)
from ppaas.planners.kernels.prefetch import LINE, fetch


@bare
def _box_of(index: Words, scratch: Integers, end: int, found: int) -> tuple[int, int, int, int]:
    """Return the bounding rectangle of all corners that an end reaches over local edges: top, bottom, left, right."""
    table, labels, labelled = integers_of(index, TABLE), integers_of(index, LABELS), index[LABELLED]
    top, left, bottom, right = np.int64(FAR), np.int64(FAR), np.int64(-1), np.int64(-1)
    for corner in end_of(index, scratch, end, NEAR)[:found]:
        if corner >= labelled:
            begin = table[corner * CORNER_SIZE + LABEL]
            top, bottom = min(top, labels[begin + TOP]), max(bottom, labels[begin + BOTTOM])
            left, right = min(left, labels[begin + LEFTMOST]), max(right, labels[begin + RIGHTMOST])
    return int(top), int(bottom), int(left), int(right)


@bare
def may_meet(index: Words, scratch: Integers, found: int, to_found: int, most: int) -> bool:
    """Return whether both ends may reach a common corner over local edges, on a path shorter than ``most``.

    Parameters
    ----------
    index, scratch
        As for `query.find_path`.
    found, to_found : int
        Number of corners that start and goal see.
    most : int
        Length of the best path so far.
    """
    if index[LANDMARK_COUNT] and lower_bound_between(scratch) >= most:
        return False
    top, bottom, left, right = _box_of(index, scratch, START, found)
    to_top, to_bottom, to_left, to_right = _box_of(index, scratch, GOAL, to_found)
    return bool(top <= to_bottom and to_top <= bottom and left <= to_right and to_left <= right)


@bare
def _may_reach_other(
    index: Words, scratch: Integers, end: int, found: int, corner: int, length: int, most: int
) -> bool:
    """Return whether a path shorter than ``most`` through a corner may meet the upward search of the end ``end``.

    Parameters
    ----------
    index, scratch
        As for `query.find_path`.
    end, found : int
        The other end, and the number of corners that it sees.
    corner, length : int
        The corner, and its distance from its own end.
    most : int
        Length of the best path so far.
    """
    table, labels, labelled = integers_of(index, TABLE), integers_of(index, LABELS), index[LABELLED]
    seen, lengths = end_of(index, scratch, end, NEAR), end_of(index, scratch, end, NEAR_LENGTHS)
    at = corner * CORNER_SIZE
    own = np.int64(table[at + LABEL])
    for i in range(found):
        to = np.int64(seen[i]) * CORNER_SIZE
        apart = octile(table[at + ROW] - table[to + ROW], table[at + COLUMN] - table[to + COLUMN])
        if seen[i] < labelled or length + apart + lengths[i] >= most:
            continue
        other = np.int64(table[to + LABEL])
        if labels[own + TOP] > labels[other + BOTTOM] or labels[other + TOP] > labels[own + BOTTOM]:
            continue
        if labels[own + LEFTMOST] <= labels[other + RIGHTMOST] and labels[other + LEFTMOST] <= labels[own + RIGHTMOST]:
            return True
    return False


@joined
def _record(
    corner: int, length: int, path: int, parent: int,
    records: Integers, count: int,
) -> int:  # fmt: skip
    """Record a corner as reached; return the number of reached corners."""
    at = RECORD * corner
    if records[at + LENGTH_SO_FAR] == FAR:
        records[RECORD * count + REACHED] = corner
        count += 1
    records[at + LENGTH_SO_FAR] = length
    records[at + PATH_TO] = path
    records[at + PARENT] = parent
    return count


@bare
def search_upwards(
    index: Words, scratch: Integers, end: int, found: int, to_found: int, to_row: int, to_column: int, most: int
) -> None:
    """Search upwards over local edges from the corners that an end sees.

    Corners are pruned if every path through them is at least ``most`` long, or if they reach nothing that the other end
    reaches.

    Parameters
    ----------
    index, scratch
        As for `query.find_path`.
    end, found, to_found : int
        The end, and the numbers of corners that it and the other end see.
    to_row, to_column : int
        Cell of the other end, including the margin.
    most : int
        Length of the best path so far.
    """
    table, labels, labelled = integers_of(index, TABLE), integers_of(index, LABELS), index[LABELLED]
    seen, lengths = end_of(index, scratch, end, NEAR), end_of(index, scratch, end, NEAR_LENGTHS)
    records, corners = fringe_of(index, scratch, end), index[CORNERS]
    heap, queued, count = heap_of(index, scratch), np.int64(0), np.int64(0)
    top, bottom, left, right = _box_of(index, scratch, 1 - end, to_found)
    # Sources: fringe corners that the end sees.
    for i in range(found):
        if seen[i] >= labelled and _may_reach_other(
            index, scratch, 1 - end, to_found, np.int64(seen[i]), np.int64(lengths[i]), most
        ):
            at = seen[i] * CORNER_SIZE
            count = _record(np.int64(seen[i]), lengths[i], np.int32(-1), np.int32(-1), records, count)
            queued = push(heap, queued, corners - seen[i], seen[i])
            for line in range(2, 5):
                fetch(labels, np.int64(table[at + LABEL]) + LINE * line)
    # Expand corners from the least important up; pruned by their bounding rectangles.
    while queued > 0:
        corner = heap[0] & NODE
        queued = pop(heap, queued)
        begin, edges = table[corner * CORNER_SIZE + LABEL], -1 - table[corner * CORNER_SIZE + ENTRIES]
        if labels[begin + TOP] > bottom or labels[begin + BOTTOM] < top:
            continue
        if labels[begin + LEFTMOST] > right or labels[begin + RIGHTMOST] < left:
            continue
        edge = begin + edges_after(labels[begin + GATE_COUNT])
        for i in range(edge, edge + edges):
            if labels[i + edges] >= 0:
                fetch(records, np.int64(labels[i]) * RECORD)
                fetch(table, np.int64(labels[i]) * CORNER_SIZE)
        reached = records[RECORD * corner + LENGTH_SO_FAR]
        for i in range(edge, edge + edges):
            to, length = np.int64(labels[i]), reached + labels[i + edges]
            if labels[i + edges] < 0 or length >= records[RECORD * to + LENGTH_SO_FAR]:
                continue
            at = to * CORNER_SIZE
            if length + octile(table[at + ROW] - to_row, table[at + COLUMN] - to_column) < most:
                if records[RECORD * to + LENGTH_SO_FAR] == FAR:
                    queued = push(heap, queued, corners - to, to)
                    for line in range(5):
                        fetch(labels, np.int64(table[at + LABEL]) + LINE * line)
                count = _record(to, length, labels[i + 2 * edges], np.int32(corner), records, count)
    scratch[TOUCHED + end] = count


@bare
def best_meeting(index: Words, scratch: Integers) -> tuple[int, int]:
    """Return the length of the shortest path through a corner that both ends reached, and that corner, or −1."""
    records, to_spots = fringe_of(index, scratch, 0), fringe_of(index, scratch, 1)
    best, meeting = int(FAR), -1
    for i in range(scratch[TOUCHED + 1]):
        corner = to_spots[RECORD * i + REACHED]
        length = records[RECORD * corner + LENGTH_SO_FAR] + to_spots[RECORD * corner + LENGTH_SO_FAR]
        if length < best:
            best, meeting = length, corner
    return best, meeting


@bare
def write_upward_path(index: Words, scratch: Integers, end: int, corner: int) -> int:
    """Write the paths from an end to a corner to the route, and return their number.

    The first corner after the end is stored in the scratch memory.
    """
    route = route_of(index, scratch)
    records = fringe_of(index, scratch, end)
    first, step = side_of(route, end)
    count, parent = 0, corner
    while records[RECORD * parent + PARENT] >= 0:
        parent = records[RECORD * parent + PARENT]
        count += 1
    scratch[CORNER + end] = parent
    for i in range(count - 1, -1, -1):
        route[first + step * i] = records[RECORD * corner + PATH_TO]
        corner = records[RECORD * corner + PARENT]
    return count


@bare
def reset_upward_search(index: Words, scratch: Integers) -> None:
    """Reset the records of all reached corners."""
    for end in range(2):
        records = fringe_of(index, scratch, end)
        for i in range(scratch[TOUCHED + end]):
            records[RECORD * records[RECORD * i + REACHED] + LENGTH_SO_FAR] = FAR
