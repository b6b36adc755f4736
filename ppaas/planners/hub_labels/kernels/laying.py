"""Kernel: lay labels and ways as `layout` has them: by the numbers of the corners, and shortcuts spelt out."""

import numpy as np
from numba import njit

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.contraction import HOPS, LEFT, RIGHT, TO
from ppaas.planners.hub_labels.kernels.layout import (
    COLUMN,
    CORNER_SIZE,
    LABEL,
    LINK_SHIFT,
    ROW,
    WAY,
    WAY_CORNERS,
    WAY_HEAD,
    WAY_MOVES,
)
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.hub_labels.kernels.trees import Rows
from ppaas.planners.kernels.bare import bare


@bare
def lay_table(
    places: Rows, ranks: Integers, begins: Words, ends: Words,
    head: Integers, after: Integers, edges: Rows, table: Integers, offsets: Integers,
) -> int:  # fmt: skip
    """Lay the table of the corners, and return the most numbers that the ways of one corner take.

    Parameters
    ----------
    places : (n, 2) int32 array
    ranks : (n,) int32 array
        How important a corner is: its number among the labels.
    begins, ends : (n,) int64 arrays
        Where the label of each rank lies.
    head, after, edges
        The contracted graph.
    table : (4 n + 4,) int32 array
        Out.
    offsets : (m,) int32 array
        Out: where each edge lies after the first of its corner.
    """
    label, way, most = 0, 0, 0
    for corner in range(len(ranks)):
        row = corner * CORNER_SIZE
        table[row + ROW] = places[corner, 0]
        table[row + COLUMN] = places[corner, 1]
        table[row + LABEL] = label
        table[row + WAY] = way
        label += 3 * (ends[ranks[corner]] - begins[ranks[corner]])
        offset = 0
        edge = head[corner]
        while edge >= 0:
            offsets[edge] = offset
            offset += WAY_HEAD + edges[edge, HOPS]
            edge = after[edge]
        way += offset
        most = max(most, offset)
    table[len(ranks) * CORNER_SIZE + LABEL] = label
    table[len(ranks) * CORNER_SIZE + WAY] = way
    return most


@bare
def _place_of(hub: int, hubs: Integers, begin: int, end: int) -> int:
    low, high = begin, end - 1
    while low < high:
        middle = (low + high) >> 1
        if hubs[middle] < hub:
            low = middle + 1
        else:
            high = middle
    return low - begin


@bare
def lay_labels(
    table: Integers, first: int, last: int, ranks: Integers, edges: Rows, offsets: Integers,
    hubs: Integers, lengths: Integers, towards: Integers, begins: Words, ends: Words, labels: Integers,
) -> None:  # fmt: skip
    """Lay the labels of the corners ``first`` to ``last``.

    Parameters
    ----------
    table, ranks, edges, offsets
        As for `lay_table`.
    first, last : int
    hubs, lengths, towards, begins, ends
        The labels by their ranks; ``towards`` is the edge towards the hub, −1 in the hub's own.
    labels : int32 array
        Out.
    """
    for corner in range(first, last):
        at, rank = table[corner * CORNER_SIZE + LABEL], ranks[corner]
        size = ends[rank] - begins[rank]
        for i in range(size):
            entry = begins[rank] + i
            labels[at + i] = hubs[entry]
            labels[at + size + i] = lengths[entry]
            edge = towards[entry]
            if edge < 0:
                labels[at + 2 * size + i] = -1
            else:
                above = ranks[edges[edge, TO]]
                place = _place_of(hubs[entry], hubs, begins[above], ends[above])
                labels[at + 2 * size + i] = (offsets[edge] << LINK_SHIFT) | place


@njit(cache=True, nogil=True, error_model="numpy")
def lay_ways(
    table: Integers, first: int, last: int, head: Integers, after: Integers, edges: Rows, ways: Integers
) -> None:
    """Lay the ways of the corners ``first`` to ``last``.

    Parameters
    ----------
    table : int32 array
    first, last : int
    head, after, edges
        The contracted graph.
    ways : int32 array
        Out.
    """
    longest = 1
    for corner in range(first, last):
        edge = head[corner]
        while edge >= 0:
            longest = max(longest, edges[edge, HOPS])
            edge = after[edge]
    stack = np.empty(longest + 1, np.int32)
    for corner in range(first, last):
        at = table[corner * CORNER_SIZE + WAY]
        edge = head[corner]
        while edge >= 0:
            at = _spell(edge, corner, edges, table, at, ways, stack)
            edge = after[edge]


@bare
def _spell(edge: int, corner: int, edges: Rows, table: Integers, at: int, ways: Integers, stack: Integers) -> int:
    begin = at
    at += WAY_HEAD
    stack[0] = edge
    depth = 1
    moves = 0
    row, column = table[corner * CORNER_SIZE + ROW], table[corner * CORNER_SIZE + COLUMN]
    while depth > 0:
        depth -= 1
        part = stack[depth]
        if edges[part, LEFT] >= 0:
            stack[depth] = edges[part, RIGHT]
            stack[depth + 1] = edges[part, LEFT] ^ 1
            depth += 2
            continue
        corner = edges[part, TO]
        next_row, next_column = table[corner * CORNER_SIZE + ROW], table[corner * CORNER_SIZE + COLUMN]
        moves += max(abs(next_row - row), abs(next_column - column))
        row, column = next_row, next_column
        ways[at] = corner
        at += 1
    ways[begin + WAY_CORNERS] = at - begin - WAY_HEAD
    ways[begin + WAY_MOVES] = moves
    return at


def warm() -> None:
    """Compile and call each kernel once."""
    nothing, starts = np.empty(0, np.int32), np.zeros(1, np.int64)
    places, edges, table = np.empty((0, 2), np.int32), np.empty((0, 5), np.int32), np.zeros(4, np.int32)
    lay_table(places, nothing, starts, starts, nothing, nothing, edges, table, nothing)
    lay_labels(table, 0, 0, nothing, edges, nothing, nothing, nothing, nothing, starts, starts, nothing)
    lay_ways(table, 0, 0, nothing, nothing, edges, nothing)
