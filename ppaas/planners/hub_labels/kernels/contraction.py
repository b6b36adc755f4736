"""Kernel: contract the graph of corners from its least important node on, as long as few ways lead through a node.

To contract a node is to take it out and to put a shortcut in for each pair of its neighbours that have no other way as
short (Geisberger, Sanders, Schultes and Delling, "Contraction Hierarchies", WEA 2008). The node with the fewest
shortcuts goes first; its price is told again when its turn comes. What is left, nodes with many neighbours each, is
called the core.

Edges lie in pairs: e leads from a to b, e ^ 1 from b to a. The edges of a node are a linked list, from ``head`` on by
``after``. A shortcut knows the two edges that it stands for, both from the node that was contracted: ``left`` to its
own beginning, ``right`` to its end; −1 and −1 in an edge of the graph itself. ``runs`` is of how many runs it is when
it is spelt out.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.heap import NODE, pop, push
from ppaas.planners.hub_labels.kernels.layout import MOST_MOVES
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.hub_labels.kernels.trees import Rows
from ppaas.planners.kernels.bare import bare, joined

SATISFIED = np.iinfo(np.int64).max
"""Stands for the length that another way to a neighbour may have at most, once one is found."""

TO, LENGTH, LEFT, RIGHT, RUNS = range(5)

ERA = 1 << 32
"""What is written by one search lies so far from that of the next."""

BIAS = np.int64(1) << 20
"""Added to prices, so that none is negative."""

EDGES, CONTRACTED, QUEUED, SEARCHES, WORK = range(5)
"""What is counted in ``counts``: edges, nodes contracted, nodes in the queue, searches so far, steps of this call."""


@bare
def link_edges(
    places: Rows, starts: Words, to: Integers, lengths: Integers,
    head: Integers, after: Integers, edges: Integers, degrees: Integers, counts: Words,
) -> None:  # fmt: skip
    """Make the linked lists of a graph.

    Parameters
    ----------
    places : (n, 2) int32 array
        Row and column of each node.
    starts, to, lengths
        For each node where its edges begin, and for each edge where it leads and how long it is: both directions.
    head, degrees : (n,) int32 arrays
        Out; ``head`` is −1 everywhere.
    after : (m,) int32 array
        Out.
    edges : (m, 5) int32 array
        Out: of each edge `TO` which node it leads, its `LENGTH`, `LEFT`, `RIGHT` and `RUNS`.
    counts : int64 array
    """
    edge = 0
    for node in range(len(head)):
        for i in range(starts[node], starts[node + 1]):
            if to[i] > node:
                rows, columns = abs(places[node, 0] - places[to[i], 0]), abs(places[node, 1] - places[to[i], 1])
                runs = _runs_of(min(rows, columns)) + _runs_of(abs(rows - columns))
                edge = _link(node, to[i], lengths[i], -1, -1, runs, edge, head, after, edges)
                degrees[node] += 1
                degrees[to[i]] += 1
    counts[EDGES] = edge


@joined
def _runs_of(moves: int) -> int:
    return (moves + MOST_MOVES - 1) // MOST_MOVES


@bare
def _link(
    a: int, b: int, length: int, left: int, right: int, runs: int, edge: int,
    head: Integers, after: Integers, edges: Integers,
) -> int:  # fmt: skip
    _set(edges, edge, b, length, left, right, runs)
    after[edge] = head[a]
    head[a] = edge
    _set(edges, edge + 1, a, length, right, left, runs)
    after[edge + 1] = head[b]
    head[b] = edge + 1
    return edge + 2


@bare
def _set(edges: Integers, edge: int, to: int, length: int, left: int, right: int, runs: int) -> None:
    edges[edge, TO] = to
    edges[edge, LENGTH] = length
    edges[edge, LEFT] = left
    edges[edge, RIGHT] = right
    edges[edge, RUNS] = runs


@bare
def _unlink(edge: int, node: int, head: Integers, after: Integers) -> None:
    at = head[node]
    if at == edge:
        head[node] = after[edge]
        return
    while after[at] != edge:
        at = after[at]
    after[at] = after[edge]


@bare
def _find_shortcuts(
    node: int, settle: int, head: Integers, after: Integers, edges: Integers,
    lengths: Words, limits: Words, heap: Words, near: Integers, pairs: Integers, counts: Words,
) -> int:  # fmt: skip
    """Write the edges of a node to ``near`` and pairs of them that need a shortcut to ``pairs``; return how many."""
    degree = 0
    edge = head[node]
    while edge >= 0:
        near[degree] = edge
        degree += 1
        edge = after[edge]
    found = 0
    for i in range(degree - 1):
        own = edges[near[i], LENGTH]
        most = 0
        for j in range(i + 1, degree):
            most = max(most, int(own + edges[near[j], LENGTH]))
        counts[SEARCHES] += 1
        era = -(int(counts[SEARCHES]) * ERA)  # what an earlier search wrote is larger than all of this one
        lengths[node] = era
        for j in range(i + 1, degree):
            limits[edges[near[j], TO]] = era + own + edges[near[j], LENGTH]
        wanted = degree - 1 - i
        _search(edges[near[i], TO], settle, most, wanted, era, head, after, edges, lengths, limits, heap, counts)
        for j in range(i + 1, degree):
            if limits[edges[near[j], TO]] != SATISFIED:
                pairs[found] = i * len(near) + j
                found += 1
    return found


@bare
def _search(
    source: int, settle: int, most: int, wanted: int, era: int, head: Integers, after: Integers, edges: Integers,
    lengths: Words, limits: Words, heap: Words, counts: Words,
) -> None:  # fmt: skip
    lengths[source] = era
    size = push(heap, 0, 0, source)
    settled = 0
    while size > 0 and settled < settle:
        node, length = heap[0] & NODE, heap[0] >> 32
        size = pop(heap, size)
        if lengths[node] != era + length:
            continue
        settled += 1
        edge = head[node]
        while edge >= 0:
            counts[WORK] += 1
            further, to = length + edges[edge, LENGTH], edges[edge, TO]
            if further <= most and era + further < lengths[to] and size < len(heap):
                lengths[to] = era + further
                size = push(heap, size, further, to)
                if limits[to] < era + ERA and era + further <= limits[to]:
                    limits[to] = SATISFIED
                    wanted -= 1
                    if wanted == 0:
                        return
            edge = after[edge]


@bare
def _take_out(
    node: int, found: int, near: Integers, pairs: Integers, head: Integers, after: Integers, edges: Integers,
    degrees: Integers, levels: Integers, counts: Words,
) -> None:  # fmt: skip
    degree = degrees[node]
    for i in range(degree):
        neighbour = edges[near[i], TO]
        _unlink(near[i] ^ 1, neighbour, head, after)
        degrees[neighbour] -= 1
        levels[neighbour] = max(levels[neighbour], levels[node] + 1)
    for pair in range(found):
        left, right = near[pairs[pair] // len(near)], near[pairs[pair] % len(near)]
        a, b = edges[left, TO], edges[right, TO]
        length, runs = edges[left, LENGTH] + edges[right, LENGTH], edges[left, RUNS] + edges[right, RUNS]
        edge = head[a]
        while edge >= 0 and edges[edge, TO] != b:
            edge = after[edge]
        if edge < 0:
            counts[EDGES] = _link(a, b, length, left, right, runs, counts[EDGES], head, after, edges)
            degrees[a] += 1
            degrees[b] += 1
        elif length < edges[edge, LENGTH]:
            _set(edges, edge, b, length, left, right, runs)
            _set(edges, edge ^ 1, a, length, right, left, runs)


@njit(cache=True, nogil=True, error_model="numpy")
def contract(
    head: Integers, after: Integers, edges: Integers, degrees: Integers, levels: Integers, order: Integers,
    queued: NDArray[np.bool_], queue: Words, prices: Integers, lengths: Words, limits: Words, heap: Words,
    counts: Words, most: int, core: int, settle: int, budget: int,
) -> bool:  # fmt: skip
    """Contract nodes until so many edges were looked at, or there is no room for more; return whether all is done.

    Parameters
    ----------
    head, after, edges, degrees
        The graph.
    levels : (n,) int32 array
        How deep a node lies under those contracted before it; zero at first.
    order : (n,) int32 array
        Out: the nodes as they were contracted.
    queued : (n,) bool array
        Whether a node is in the queue.
    queue : (n,) int64 array
        A heap of nodes by the price of contracting them, ``counts[QUEUED]`` long; at first all, at 0 or their own.
    prices : (n,) int32 array
        What it costs to contract each, where that is known before; else empty.
    lengths, limits : (n,) int64 arrays
        Scratch; 0 at first.
    heap : int64 array
        Scratch; the longer, the further searches go.
    counts : (5,) int64 array
    most : int
        Neighbours that a node may have to be contracted.
    core : int
        How many nodes are left at least.
    settle : int
        Nodes that a search for another way may settle.
    budget : int
    """
    near, pairs = np.empty(most, np.int32), np.empty(most * most, np.int32)
    counts[WORK] = 0
    while counts[QUEUED] > 0 and counts[WORK] < budget and counts[EDGES] + most * most <= len(after):
        if len(head) - counts[CONTRACTED] <= core:
            return True
        node = queue[0] & NODE
        counts[QUEUED] = pop(queue, counts[QUEUED])
        queued[node] = False
        counts[WORK] += 1
        if degrees[node] > most:
            continue
        found = _find_shortcuts(node, settle, head, after, edges, lengths, limits, heap, near, pairs, counts)
        price = 2 * (found - degrees[node]) + levels[node] + BIAS
        if len(prices) == 0 and counts[QUEUED] > 0 and ((price << 32) | node) > queue[0]:
            counts[QUEUED] = push(queue, counts[QUEUED], price, node)
            queued[node] = True
            continue
        _take_out(node, found, near, pairs, head, after, edges, degrees, levels, counts)
        order[counts[CONTRACTED]] = node
        counts[CONTRACTED] += 1
        for i in range(degrees[node]):
            neighbour = edges[near[i], TO]
            if not queued[neighbour] and degrees[neighbour] <= most:
                counts[QUEUED] = push(queue, counts[QUEUED], prices[neighbour] if len(prices) else 0, neighbour)
                queued[neighbour] = True
    return bool(counts[QUEUED] == 0)


def warm() -> None:
    """Compile and call each kernel once."""
    starts, to, lengths = np.array([0, 1, 2]), np.array([1, 0], np.int32), np.ones(2, np.int32)
    numbers = np.zeros((3, 2), np.int32)
    head, after, edges = np.full(2, -1, np.int32), np.empty(2, np.int32), np.empty((2, 5), np.int32)
    counts = np.zeros(5, np.int64)
    link_edges(np.zeros((2, 2), np.int32), starts, to, lengths, head, after, edges, numbers[0], counts)
    far = np.zeros(2, np.int64)
    contract(
        head,
        after,
        edges,
        numbers[0],
        numbers[1],
        numbers[2],
        np.zeros(2, np.bool_),
        far,
        numbers[0],
        far.copy(),
        far.copy(),
        far.copy(),
        counts,
        1,
        0,
        1,
        1,
    )
