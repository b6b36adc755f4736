"""Kernel: look for a way between two ends that touches no corner with a label: go up from both until they meet.

Each corner of the fringe has edges to more important corners only, and the shortest way between any two corners goes
up from both of them to where they meet (Geisberger, Sanders, Schultes and Delling, "Contraction Hierarchies", WEA
2008). Only local edges need be looked at, nothing that is too long beside the best way over labels, and nothing at all
where the rectangles are apart that hold what both reach. The least important corners are left first, so each is left
once.
"""

import numpy as np

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.heap import NODE, pop, push
from ppaas.planners.hub_labels.kernels.joining import least_between
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
    BELOW,
    CORNER,
    FAR_OFF,
    GOAL,
    JOINED,
    JOINED_LENGTHS,
    REACHED,
    SPOT,
    START,
    TOUCHED,
    WAY,
    end_of,
    fringe_of,
    heap_of,
    route_of,
    side_of,
)
from ppaas.planners.kernels.jit_decorators import bare, joined
from ppaas.planners.kernels.prefetch import LINE, fetch


@bare
def _box_of(index: Words, scratch: Integers, end: int, found: int) -> tuple[int, int, int, int]:
    """Return the rectangle that holds all corners which an end reaches over local edges."""
    table, labels, labelled = integers_of(index, TABLE), integers_of(index, LABELS), index[LABELLED]
    top, left, bottom, right = np.int64(FAR), np.int64(FAR), np.int64(-1), np.int64(-1)
    for corner in end_of(index, scratch, end, JOINED)[:found]:
        if corner >= labelled:
            begin = table[corner * CORNER_SIZE + LABEL]
            top, bottom = min(top, labels[begin + TOP]), max(bottom, labels[begin + BOTTOM])
            left, right = min(left, labels[begin + LEFTMOST]), max(right, labels[begin + RIGHTMOST])
    return int(top), int(bottom), int(left), int(right)


@bare
def may_meet(index: Words, scratch: Integers, found: int, to_found: int, most: int) -> bool:
    """Tell whether two ends that see so many corners may reach the same over local edges, on a way below ``most``."""
    if index[LANDMARK_COUNT] and least_between(scratch) >= most:
        return False
    top, bottom, left, right = _box_of(index, scratch, START, found)
    to_top, to_bottom, to_left, to_right = _box_of(index, scratch, GOAL, to_found)
    return bool(top <= to_bottom and to_top <= bottom and left <= to_right and to_left <= right)


@bare
def _may_lead(index: Words, scratch: Integers, end: int, found: int, corner: int, length: int, most: int) -> bool:
    """Tell whether a way below ``most`` over a corner, so far from one end, may meet one that the other end sees."""
    table, labels, labelled = integers_of(index, TABLE), integers_of(index, LABELS), index[LABELLED]
    seen, lengths = end_of(index, scratch, end, JOINED), end_of(index, scratch, end, JOINED_LENGTHS)
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
def _reach(
    corner: int, length: int, way: int, below: int,
    spots: Integers, count: int,
) -> int:  # fmt: skip
    at = SPOT * corner
    if spots[at + FAR_OFF] == FAR:
        spots[SPOT * count + REACHED] = corner
        count += 1
    spots[at + FAR_OFF] = length
    spots[at + WAY] = way
    spots[at + BELOW] = below
    return count


@bare
def climb(
    index: Words, scratch: Integers, end: int, found: int, to_found: int, to_row: int, to_column: int, most: int
) -> None:
    """Reach corners over local edges from those which an end sees; the other end sees ``to_found`` of them.

    Corners are left out over which any way to the other end is as long as ``most``, and those from which nothing is
    reached that the other end reaches.
    """
    table, labels, labelled = integers_of(index, TABLE), integers_of(index, LABELS), index[LABELLED]
    seen, lengths = end_of(index, scratch, end, JOINED), end_of(index, scratch, end, JOINED_LENGTHS)
    spots, corners = fringe_of(index, scratch, end), index[CORNERS]
    heap, queued, count = heap_of(index, scratch), np.int64(0), np.int64(0)
    top, bottom, left, right = _box_of(index, scratch, 1 - end, to_found)
    for i in range(found):
        if seen[i] >= labelled and _may_lead(
            index, scratch, 1 - end, to_found, np.int64(seen[i]), np.int64(lengths[i]), most
        ):
            at = seen[i] * CORNER_SIZE
            count = _reach(np.int64(seen[i]), lengths[i], np.int32(-1), np.int32(-1), spots, count)
            queued = push(heap, queued, corners - seen[i], seen[i])
            for line in range(2, 5):
                fetch(labels, np.int64(table[at + LABEL]) + LINE * line)
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
                fetch(spots, np.int64(labels[i]) * SPOT)
                fetch(table, np.int64(labels[i]) * CORNER_SIZE)
        reached = spots[SPOT * corner + FAR_OFF]
        for i in range(edge, edge + edges):
            to, length = np.int64(labels[i]), reached + labels[i + edges]
            if labels[i + edges] < 0 or length >= spots[SPOT * to + FAR_OFF]:
                continue
            at = to * CORNER_SIZE
            if length + octile(table[at + ROW] - to_row, table[at + COLUMN] - to_column) < most:
                if spots[SPOT * to + FAR_OFF] == FAR:
                    queued = push(heap, queued, corners - to, to)
                    for line in range(5):
                        fetch(labels, np.int64(table[at + LABEL]) + LINE * line)
                count = _reach(to, length, labels[i + 2 * edges], np.int32(corner), spots, count)
    scratch[TOUCHED + end] = count


@bare
def meet(index: Words, scratch: Integers) -> tuple[int, int]:
    """Return the corner that both ends reached over which the way is shortest, or −1, and how long that is."""
    spots, to_spots = fringe_of(index, scratch, 0), fringe_of(index, scratch, 1)
    best, meeting = int(FAR), -1
    for i in range(scratch[TOUCHED + 1]):
        corner = to_spots[SPOT * i + REACHED]
        length = spots[SPOT * corner + FAR_OFF] + to_spots[SPOT * corner + FAR_OFF]
        if length < best:
            best, meeting = length, corner
    return best, meeting


@bare
def lead(index: Words, scratch: Integers, end: int, corner: int) -> int:
    """Write the ways that lead from an end to a corner to the route, and return how many they are.

    The corner next to the end is told in the scratch.
    """
    route = route_of(index, scratch)
    spots = fringe_of(index, scratch, end)
    first, step = side_of(route, end)
    count, below = 0, corner
    while spots[SPOT * below + BELOW] >= 0:
        below = spots[SPOT * below + BELOW]
        count += 1
    scratch[CORNER + end] = below
    for i in range(count - 1, -1, -1):
        route[first + step * i] = spots[SPOT * corner + WAY]
        corner = spots[SPOT * corner + BELOW]
    return count


@bare
def descend(index: Words, scratch: Integers) -> None:
    """Forget what was reached."""
    for end in range(2):
        spots = fringe_of(index, scratch, end)
        for i in range(scratch[TOUCHED + end]):
            spots[SPOT * spots[SPOT * i + REACHED] + FAR_OFF] = FAR
