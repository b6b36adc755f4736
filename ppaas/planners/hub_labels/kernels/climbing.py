"""Kernel: go from the corners next to an end up through the fringe, to the corners that have labels.

Each corner of the fringe has edges to more important corners only, and the shortest way between any two corners goes
up from both of them to where they meet (Geisberger, Sanders, Schultes and Delling, "Contraction Hierarchies", WEA
2008). Either that is a corner that both ends reach in the fringe, or the ways lead over corners with labels. The least
important corners are left first, so each is left once.
"""

import numpy as np

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.heap import NODE, pop, push
from ppaas.planners.hub_labels.kernels.layout import (
    COLUMN,
    CORNER_SIZE,
    ENTRIES,
    LABEL,
    LABELS,
    RANKS,
    ROW,
    TABLE,
    WAYS,
    integers_of,
    moves_of,
    shorts_of,
)
from ppaas.planners.hub_labels.kernels.scan import Integers, octile
from ppaas.planners.hub_labels.kernels.scratch import (
    CORNER,
    MOVES,
    TOUCHED,
    end_of,
    fringe_of,
    heap_of,
    route_of,
    side_of,
)
from ppaas.planners.hub_labels.kernels.trees import FAR
from ppaas.planners.kernels.bare import bare, joined


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
def climb(index: Words, scratch: Integers, end: int, found: int, to_row: int, to_column: int, most: int) -> int:
    """Replace the corners that an end sees by those with labels that are reached from them; return how many.

    Corners are left out over which any way to the other end is longer than ``most``.
    """
    table, labels, ranks = integers_of(index, TABLE), integers_of(index, LABELS), integers_of(index, RANKS)
    seen, lengths = end_of(index, scratch, end, 0), end_of(index, scratch, end, 1)
    near, came = fringe_of(index, scratch, end, 0), fringe_of(index, scratch, end, 1)
    before, touched = fringe_of(index, scratch, end, 2), fringe_of(index, scratch, end, 3)
    heap, queued, count = heap_of(index, scratch), np.int64(0), np.int64(0)
    for i in range(found):
        at = seen[i] * CORNER_SIZE
        if lengths[i] + octile(table[at + ROW] - to_row, table[at + COLUMN] - to_column) > most:
            continue
        count = _reach(np.int64(seen[i]), lengths[i], np.int32(-1), np.int32(-1), near, came, before, touched, count)
        if table[at + ENTRIES] < 0:
            queued = push(heap, queued, len(near) - ranks[seen[i]], seen[i])
    while queued > 0:
        corner = heap[0] & NODE
        queued = pop(heap, queued)
        edge, edges = table[corner * CORNER_SIZE + LABEL], -1 - table[corner * CORNER_SIZE + ENTRIES]
        for i in range(edge, edge + edges):
            to, length = labels[i], near[corner] + labels[i + edges]
            at = to * CORNER_SIZE
            if length < near[to] and length + octile(table[at + ROW] - to_row, table[at + COLUMN] - to_column) <= most:
                if near[to] == FAR and table[at + ENTRIES] < 0:
                    queued = push(heap, queued, len(near) - ranks[to], to)
                count = _reach(
                    np.int64(to), length, labels[i + 2 * edges], np.int32(corner), near, came, before, touched, count
                )
    scratch[TOUCHED + end] = count
    found = 0
    for corner in touched[:count]:
        if table[corner * CORNER_SIZE + ENTRIES] >= 0:
            seen[found] = corner
            lengths[found] = near[corner]
            found += 1
    return found


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
    ways, route = shorts_of(index, WAYS), route_of(index, scratch)
    came, before = fringe_of(index, scratch, end, 1), fringe_of(index, scratch, end, 2)
    first, step = side_of(route, end)
    count, below = 0, corner
    while before[below] >= 0:
        below = before[below]
        count += 1
    scratch[CORNER + end] = below
    for i in range(count - 1, -1, -1):
        route[first + step * i] = came[corner]
        scratch[MOVES] += moves_of(ways, came[corner])
        corner = before[corner]
    return count


@bare
def descend(index: Words, scratch: Integers) -> None:
    """Forget what was reached."""
    for end in range(2):
        near, touched = fringe_of(index, scratch, end, 0), fringe_of(index, scratch, end, 3)
        for corner in touched[: scratch[TOUCHED + end]]:
            near[corner] = FAR
