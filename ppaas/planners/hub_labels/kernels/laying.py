"""Kernel: lay labels and edges as a query wants them: by the numbers of the corners, and edges corner by corner.

An entry of a label links to the entry of the same hub in the label one edge nearer to the hub: its *link* is the place
of that edge among the edges of the corner, shifted by `LINK_SHIFT`, and the place of the entry in that label; −1 in the
label of the hub itself.
"""

import numpy as np
from numba import njit

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.contraction import HOPS, LEFT, RIGHT, TO
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.hub_labels.kernels.trees import Rows

LINK_SHIFT = 16
MOST_LINKED = (1 << (31 - LINK_SHIFT)) - 1
"""Edges of a corner, and by twice as many entries of a label, that links can tell apart."""


@njit(cache=True, nogil=True, error_model="numpy")
def _place_of(hub: int, hubs: Integers, begin: int, end: int) -> int:
    low, high = begin, end - 1
    while low < high:
        middle = (low + high) >> 1
        if hubs[middle] < hub:
            low = middle + 1
        else:
            high = middle
    return low - begin


@njit(cache=True, nogil=True, error_model="numpy")
def lay_labels(
    ranks: Integers, first: int, last: int, edges: Rows, places: Integers,
    hubs: Integers, lengths: Integers, towards: Integers, begins: Words, ends: Words,
    label_begins: Words, label_hubs: Integers, label_lengths: Integers, links: Integers,
) -> None:  # fmt: skip
    """Lay the labels of the corners ``first`` to ``last``.

    Parameters
    ----------
    ranks : (n,) int32 array
        How important a corner is: its number in the pool.
    first, last : int
    edges : (m, 5) int32 array
    places : (m,) int32 array
        Place of each edge among those of its corner.
    hubs, lengths, towards, begins, ends
        The pool.
    label_begins : (n + 1,) int64 array
    label_hubs, label_lengths, links : int32 arrays
        Out.
    """
    for corner in range(first, last):
        at = label_begins[corner]
        rank = ranks[corner]
        for i in range(begins[rank], ends[rank]):
            label_hubs[at] = hubs[i]
            label_lengths[at] = lengths[i]
            edge = towards[i]
            if edge < 0:
                links[at] = -1
            else:
                above = ranks[edges[edge, TO]]
                links[at] = (places[edge] << LINK_SHIFT) | _place_of(hubs[i], hubs, begins[above], ends[above])
            at += 1


@njit(cache=True, nogil=True, error_model="numpy")
def count_edges(head: Integers, after: Integers, edges: Rows, begins: Words, places: Integers) -> int:
    """Number the edges by their corners, and return the hops of all of them.

    Parameters
    ----------
    head, after, edges
        The contracted graph.
    begins : (n + 1,) int64 array
        Out: where the edges of a corner begin.
    places : (m,) int32 array
        Out: place of each edge among those of its corner.
    """
    hops = 0
    begins[0] = 0
    for corner in range(len(head)):
        count = 0
        edge = head[corner]
        while edge >= 0:
            places[edge] = count
            hops += edges[edge, HOPS]
            count += 1
            edge = after[edge]
        begins[corner + 1] = begins[corner] + count
    return hops


@njit(cache=True, nogil=True, error_model="numpy")
def lay_edges(
    head: Integers,
    after: Integers,
    edges: Rows,
    begins: Words,
    first: int,
    last: int,
    way_begins: Words,
    ways: Integers,
) -> None:
    """Spell out the edges of the corners ``first`` to ``last``: the corners that each leads to, up to its end.

    Parameters
    ----------
    head, after, edges, begins
        The contracted graph, and where the edges of a corner begin.
    first, last : int
    way_begins : (m + 1,) int64 array
        Out: where the corners of an edge begin; that of the first edge is given.
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
    at = begins[first]
    for corner in range(first, last):
        edge = head[corner]
        while edge >= 0:
            way_begins[at + 1] = _spell(edge, edges, way_begins[at], ways, stack)
            at += 1
            edge = after[edge]


@njit(cache=True, nogil=True, error_model="numpy")
def _spell(edge: int, edges: Rows, at: int, ways: Integers, stack: Integers) -> int:
    stack[0] = edge
    depth = 1
    while depth > 0:
        depth -= 1
        part = stack[depth]
        if edges[part, LEFT] < 0:
            ways[at] = edges[part, TO]
            at += 1
        else:
            stack[depth] = edges[part, RIGHT]
            stack[depth + 1] = edges[part, LEFT] ^ 1
            depth += 2
    return at


def warm() -> None:
    """Compile and call each kernel once."""
    nothing, starts, edges = np.empty(0, np.int32), np.zeros(1, np.int64), np.empty((0, 5), np.int32)
    lay_labels(
        nothing, 0, 0, edges, nothing, nothing, nothing, nothing, starts, starts, starts, nothing, nothing, nothing
    )
    count_edges(nothing, nothing, edges, starts, nothing)
    lay_edges(nothing, nothing, edges, starts, 0, 0, starts, nothing)
