"""Kernel: look for a way between two ends that touches no corner with a label: go up from both until they meet.

Each corner of the fringe has edges to more important corners only, and the shortest way between any two corners goes
up from both of them to where they meet (Geisberger, Sanders, Schultes and Delling, "Contraction Hierarchies", WEA
2008). Only local edges need be looked at, nothing that is too long beside the best way over labels, and nothing at all
where the rectangles are apart that hold what both reach. The least important corners are left first, so each is left
once.
"""

import numpy as np

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.fetching import LINE, fetch
from ppaas.planners.hub_labels.kernels.gates import BOTTOM, LEFTMOST, RIGHTMOST, TOP
from ppaas.planners.hub_labels.kernels.heap import NODE, pop, push
from ppaas.planners.hub_labels.kernels.layout import (
    COLUMN,
    CORNER_SIZE,
    ENTRIES,
    GATE_COUNT,
    LABEL,
    LABELLED,
    LABELS,
    ROW,
    TABLE,
    edges_after,
    integers_of,
)
from ppaas.planners.hub_labels.kernels.scan import Integers, octile
from ppaas.planners.hub_labels.kernels.scratch import (
    CORNER,
    GOAL,
    JOINED,
    JOINED_LENGTHS,
    START,
    TOUCHED,
    end_of,
    fringe_of,
    heap_of,
    route_of,
    side_of,
)
from ppaas.planners.hub_labels.kernels.trees import FAR
from ppaas.planners.kernels.bare import bare, joined


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
def may_meet(index: Words, scratch: Integers, found: int, to_found: int) -> bool:
    """Tell whether two ends that see so many corners may reach the same over local edges."""
    top, bottom, left, right = _box_of(index, scratch, START, found)
    to_top, to_bottom, to_left, to_right = _box_of(index, scratch, GOAL, to_found)
    return bool(top <= to_bottom and to_top <= bottom and left <= to_right and to_left <= right)


@joined
def _reach(
    corner: int, length: int, way: int, below: int,
    near: Integers, came: Integers, before: Integers, touched: Integers, count: int,
) -> int:  # fmt: skip
    if near[corner] == FAR:
        touched[count] = corner
        count += 1
    near[corner] = length
    came[corner] = way
    before[corner] = below
    return count


@bare
def climb(index: Words, scratch: Integers, end: int, found: int, to_row: int, to_column: int, most: int) -> None:
    """Reach corners over local edges from those which an end sees.

    Corners are left out over which any way to the other end is as long as ``most``.
    """
    table, labels, labelled = integers_of(index, TABLE), integers_of(index, LABELS), index[LABELLED]
    seen, lengths = end_of(index, scratch, end, JOINED), end_of(index, scratch, end, JOINED_LENGTHS)
    near, came = fringe_of(index, scratch, end, 0), fringe_of(index, scratch, end, 1)
    before, touched = fringe_of(index, scratch, end, 2), fringe_of(index, scratch, end, 3)
    heap, queued, count = heap_of(index, scratch), np.int64(0), np.int64(0)
    for i in range(found):
        at = seen[i] * CORNER_SIZE
        bound = lengths[i] + octile(table[at + ROW] - to_row, table[at + COLUMN] - to_column)
        if seen[i] >= labelled and bound < most:
            count = _reach(
                np.int64(seen[i]), lengths[i], np.int32(-1), np.int32(-1), near, came, before, touched, count
            )
            queued = push(heap, queued, len(near) - seen[i], seen[i])
            for line in range(1, 4):
                fetch(labels, np.int64(table[at + LABEL]) + LINE * line)
    while queued > 0:
        corner = heap[0] & NODE
        queued = pop(heap, queued)
        begin, edges = table[corner * CORNER_SIZE + LABEL], -1 - table[corner * CORNER_SIZE + ENTRIES]
        edge = begin + edges_after(labels[begin + GATE_COUNT])
        for i in range(edge, edge + edges):
            to, length = labels[i], near[corner] + labels[i + edges]
            if labels[i + edges] < 0 or length >= near[to]:
                continue
            at = to * CORNER_SIZE
            if length + octile(table[at + ROW] - to_row, table[at + COLUMN] - to_column) < most:
                if near[to] == FAR:
                    queued = push(heap, queued, len(near) - to, to)
                    for line in range(4):
                        fetch(labels, np.int64(table[at + LABEL]) + LINE * line)
                count = _reach(
                    np.int64(to), length, labels[i + 2 * edges], np.int32(corner), near, came, before, touched, count
                )
    scratch[TOUCHED + end] = count


@bare
def meet(index: Words, scratch: Integers) -> tuple[int, int]:
    """Return the corner that both ends reached over which the way is shortest, or −1, and how long that is."""
    near, to_near = fringe_of(index, scratch, 0, 0), fringe_of(index, scratch, 1, 0)
    best, meeting = int(FAR), -1
    for corner in fringe_of(index, scratch, 1, 3)[: scratch[TOUCHED + 1]]:
        length = near[corner] + to_near[corner]
        if length < best:
            best, meeting = length, corner
    return best, meeting


@bare
def lead(index: Words, scratch: Integers, end: int, corner: int) -> int:
    """Write the ways that lead from an end to a corner to the route, and return how many they are.

    The corner next to the end is told in the scratch.
    """
    route = route_of(index, scratch)
    came, before = fringe_of(index, scratch, end, 1), fringe_of(index, scratch, end, 2)
    first, step = side_of(route, end)
    count, below = 0, corner
    while before[below] >= 0:
        below = before[below]
        count += 1
    scratch[CORNER + end] = below
    for i in range(count - 1, -1, -1):
        route[first + step * i] = came[corner]
        corner = before[corner]
    return count


@bare
def descend(index: Words, scratch: Integers) -> None:
    """Forget what was reached."""
    for end in range(2):
        near, touched = fringe_of(index, scratch, end, 0), fringe_of(index, scratch, end, 3)
        for corner in touched[: scratch[TOUCHED + end]]:
            near[corner] = FAR
