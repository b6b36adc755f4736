"""Kernel: lay labels and ways as `layout` has them: by the numbers of the corners, and shortcuts spelt out."""

import numpy as np
from numba import njit

from ppaas.planners.hub_labels.building.kernels.contraction import LEFT, LENGTH, RIGHT, RUNS, TO
from ppaas.planners.hub_labels.building.kernels.trees import Rows
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import (
    COLUMN,
    CORNER_SIZE,
    DIRECTIONS,
    ENTRIES,
    FRINGE_HEAD,
    GATE_COUNT,
    LABEL,
    LAST,
    LINK_NEXT,
    LINK_SIZE,
    LINK_WAY,
    MOST_MOVES,
    ROW,
    Shorts,
    edges_after,
    fringe_size,
    label_size,
    lengths_after,
    links_after,
)
from ppaas.planners.hub_labels.kernels.path_cells import direction_of
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.kernels.jit_decorators import bare, joined


@bare
def lay_table(
    places: Rows, ranks: Integers, begins: Words, ends: Words, labelled: int, gates: Words,
    head: Integers, after: Integers, edges: Rows, table: Rows, offsets: Integers, sizes: Words,
) -> None:  # fmt: skip
    """Lay the table of the corners, and tell how much room labels and ways take.

    Parameters
    ----------
    places : (n, 2) int32 array
    ranks : (n,) int32 array
        How important a corner is: its number among the labels.
    begins, ends : (n,) int64 arrays
        Where the label of each rank lies.
    labelled : int
        How many have labels; the rest is the fringe.
    gates : (n,) int64 array
        How many gates each rank has.
    head, after, edges
        The contracted graph.
    table : (n, 4) int32 array
        Out, by ranks.
    offsets : (m,) int32 array
        Out: where each edge lies among the ways.
    sizes : (2,) int64 array
        Out: numbers of all labels, and of all ways; what is laid is of no use where one is more than an int32 tells.
    """
    label, way = np.int64(0), np.int64(0)
    for corner in range(len(ranks)):
        rank = ranks[corner]
        table[rank, ROW] = places[corner, 0]
        table[rank, COLUMN] = places[corner, 1]
        table[rank, LABEL] = label
        edge, count = head[corner], 0
        while edge >= 0:
            offsets[edge] = way
            way += edges[edge, RUNS]
            edge = after[edge]
            count += 1
        entries = ends[rank] - begins[rank] if rank < labelled else -1 - count
        table[rank, ENTRIES] = entries
        label += label_size(entries) if entries >= 0 else fringe_size(count, gates[rank])
    sizes[0] = label
    sizes[1] = way


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
def lay_fringe(
    table: Rows, first: int, last: int, ranks: Integers,
    head: Integers, after: Integers, edges: Rows, offsets: Integers,
    gates: Integers, lengths: Integers, begins: Words, ends: Words, local: Words, boxes: Rows, labels: Integers,
) -> None:  # fmt: skip
    """Lay what is told of the corners ``first`` to ``last`` of the fringe.

    Parameters
    ----------
    table, ranks, head, after, edges, offsets
        As for `lay_table`.
    first, last : int
    gates, lengths, begins, ends, local, boxes
        As `gates` has them; ``local`` by the numbers of edges.
    labels : int32 array
        Out.
    """
    for corner in range(first, last):
        rank = ranks[corner]
        at, count, begin = table[rank, LABEL], -1 - table[rank, ENTRIES], begins[rank]
        if count < 0:
            continue
        found = ends[rank] - begin
        for side in range(GATE_COUNT):
            labels[at + side] = boxes[rank, side]
        labels[at + GATE_COUNT] = found
        for i in range(found):
            labels[at + FRINGE_HEAD + i] = gates[begin + i]
            labels[at + FRINGE_HEAD + found + i] = lengths[begin + i]
        edge = head[corner]
        for i in range(at + edges_after(found), at + edges_after(found) + count):
            labels[i] = ranks[edges[edge, TO]]
            labels[i + count] = edges[edge, LENGTH] if local[edge] else -edges[edge, LENGTH]
            labels[i + 2 * count] = offsets[edge]
            edge = after[edge]


@bare
def lay_labels(
    table: Rows, first: int, last: int, ranks: Integers, edges: Rows, offsets: Integers,
    hubs: Integers, lengths: Integers, towards: Integers, begins: Words, ends: Words, labels: Integers, short: Shorts,
) -> None:  # fmt: skip
    """Lay the labels of the corners ``first`` to ``last``, where they have one.

    Parameters
    ----------
    table, ranks, edges, offsets
        As for `lay_table`.
    first, last : int
    hubs, lengths, towards, begins, ends
        The labels by their ranks; ``towards`` is the edge towards the hub, −1 in the hub's own.
    labels : int32 array
        Out.
    short : uint16 array
        The same memory.
    """
    for corner in range(first, last):
        rank = ranks[corner]
        at, size, own = table[rank, LABEL], table[rank, ENTRIES], begins[rank]
        if size < 0:
            continue
        if size & 1:
            short[2 * at + size] = 0
        for i in range(size):
            hub, edge = hubs[own + i], towards[own + i]
            link = at + links_after(size) + LINK_SIZE * i
            short[2 * at + i] = hub
            labels[at + lengths_after(size) + i] = lengths[own + i]
            labels[link + LINK_NEXT] = -1
            labels[link + LINK_WAY] = -1 if edge < 0 else offsets[edge]
            if edge >= 0 and ranks[edges[edge, TO]] != hub:
                above = ranks[edges[edge, TO]]
                place = _place_of(hub, hubs, begins[above], ends[above])
                labels[link + LINK_NEXT] = table[above, LABEL] + links_after(table[above, ENTRIES]) + LINK_SIZE * place


@njit(cache=True, nogil=True, error_model="numpy")
def lay_ways(
    places: Rows, first: int, last: int, head: Integers, after: Integers, edges: Rows, offsets: Integers, ways: Shorts
) -> None:
    """Lay the ways of the corners ``first`` to ``last``.

    Parameters
    ----------
    places : (n, 2) int32 array
    first, last : int
    head, after, edges
        The contracted graph.
    offsets : (m,) int32 array
        Where each edge lies among the ways.
    ways : uint16 array
        Out.
    """
    longest = 1
    for corner in range(first, last):
        edge = head[corner]
        while edge >= 0:
            longest = max(longest, edges[edge, RUNS])
            edge = after[edge]
    stack = np.empty(longest + 1, np.int32)
    for corner in range(first, last):
        edge = head[corner]
        while edge >= 0:
            _spell(edge, corner, edges, places, offsets[edge], ways, stack)
            edge = after[edge]


@bare
def _spell(edge: int, corner: int, edges: Rows, places: Rows, begin: int, ways: Shorts, stack: Integers) -> None:
    at = begin
    stack[0] = edge
    depth = 1
    while depth > 0:
        depth -= 1
        part = stack[depth]
        if edges[part, LEFT] >= 0:
            stack[depth] = edges[part, RIGHT]
            stack[depth + 1] = edges[part, LEFT] ^ 1
            depth += 2
            continue
        to = edges[part, TO]
        rows, columns = places[to, 0] - places[corner, 0], places[to, 1] - places[corner, 1]
        down, right = (rows > 0) - (rows < 0), (columns > 0) - (columns < 0)
        rows, columns = abs(rows), abs(columns)
        diagonal = min(rows, columns)
        at = _put(ways, at, direction_of(down, right), diagonal)
        if rows > columns:
            at = _put(ways, at, direction_of(down, 0), rows - diagonal)
        else:
            at = _put(ways, at, direction_of(0, right), columns - diagonal)
        corner = to
    ways[at - 1] |= LAST


@joined
def _put(ways: Shorts, at: int, direction: int, moves: int) -> int:
    while moves > 0:
        run = min(moves, MOST_MOVES)
        ways[at] = (run << DIRECTIONS) | direction
        moves -= run
        at += 1
    return at


def warm() -> None:
    """Compile and call each kernel once."""
    nothing, starts = np.empty(0, np.int32), np.zeros(2, np.int64)
    places, edges = np.empty((0, 2), np.int32), np.empty((0, 5), np.int32)
    table, ways = np.empty((0, CORNER_SIZE), np.int32), np.empty(0, np.uint16)
    lay_table(places, nothing, starts, starts, 0, starts, nothing, nothing, edges, table, nothing, starts)
    lay_labels(table, 0, 0, nothing, edges, nothing, nothing, nothing, nothing, starts, starts, nothing, ways)
    lay_fringe(
        table, 0, 0, nothing, nothing, nothing, edges, nothing,
        nothing, nothing, starts, starts, starts, table, nothing,
    )  # fmt: skip
    lay_ways(places, 0, 0, nothing, nothing, edges, nothing, ways)
