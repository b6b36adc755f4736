"""Kernel: contraction of the graph of corners, from its least important nodes on.

Contracting a node removes it and adds a shortcut for each pair of its neighbours without another path as short, a
*witness* (Geisberger, Sanders, Schultes and Delling, "Contraction Hierarchies", WEA 2008). Nodes with the fewest
shortcuts are contracted first (`contraction_order`). The nodes that are left, which have many neighbours, form the
core.

Edges come in pairs: e leads from a to b, e ^ 1 from b to a. A shortcut stores the two edges that it replaces, both seen
from the contracted node: ``left`` to its own begin, ``right`` to its end. Both are −1 in an edge of the original graph.
``runs`` is the number of runs of its path. The neighbours of a node are a contiguous range of rows. A full range moves
to the end, with twice the capacity.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare, compiled, joined
from ppaas.planners.hub_labels.building.kernels.trees import Rows
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import MOST_MOVES
from ppaas.planners.hub_labels.kernels.scan import Integers

Flags = NDArray[np.bool_]

TO, LENGTH, LEFT, RIGHT, RUNS = range(5)
"""Columns of an edge."""

NODE, LENGTH_TO, EDGE = range(3)
"""Columns of a row: the neighbour, its distance, and the edge to it."""

FIRST_CAPACITY = 8
"""Initial spare capacity of a node for neighbours."""

PAIR_BITS = 16
"""A pair of neighbours is a number: the index of the second in the lower bits, and that of the first above."""

FOUND, FIRST, SLOT = range(3)
"""Columns of the counts of a node of a round: number of pairs that need a shortcut, index of the first, and the slot
that has them."""

EDGES, CONTRACTED, USED, NEXT = range(4)
"""Counters in ``state``: edges, contracted nodes, used rows, and finished nodes of this round."""


@bare
def build_rows(
    positions: Rows, starts: Words, to: Integers, lengths: Integers,
    begins: Words, degrees: Integers, capacities: Integers, rows: Rows, edges: Rows, state: Words,
) -> None:  # fmt: skip
    """Store the neighbours of each node as contiguous rows.

    Parameters
    ----------
    positions : (n, 2) int32 array
        Row and column of each node.
    starts : (n + 1,) int64 array
        First edge of each node.
    to, lengths : int32 arrays
        End and length of each edge, in both directions.
    begins : (n,) int64 array
        Out: first row of each node.
    degrees, capacities : (n,) int32 arrays
        Out: number of neighbours of each node, and capacity for them; degrees are zero at first.
    rows : (k, 3) int32 array
        Out: `NODE`, `LENGTH_TO` and `EDGE` of each neighbour.
    edges : (m, 5) int32 array
        Out: `TO`, `LENGTH`, `LEFT`, `RIGHT` and `RUNS` of each edge.
    state : (4,) int64 array
        Counters, zero at first.
    """
    for node in range(len(begins)):
        begins[node] = state[USED]
        capacities[node] = FIRST_CAPACITY + starts[node + 1] - starts[node]
        state[USED] += capacities[node]
    for node in range(len(begins)):
        for i in range(starts[node], starts[node + 1]):
            if to[i] > node:
                down, right = (
                    abs(positions[node, 0] - positions[to[i], 0]),
                    abs(positions[node, 1] - positions[to[i], 1]),
                )
                runs = _runs_of(min(down, right)) + _runs_of(abs(down - right))
                _add_edge_pair(node, to[i], lengths[i], -1, -1, runs, begins, degrees, rows, edges, state)


@joined
def _runs_of(moves: int) -> int:
    return (moves + MOST_MOVES - 1) // MOST_MOVES


@bare
def _add_edge_pair(
    a: int, b: int, length: int, left: int, right: int, runs: int,
    begins: Words, degrees: Integers, rows: Rows, edges: Rows, state: Words,
) -> None:  # fmt: skip
    edge = state[EDGES]
    _set_edge(edges, edge, b, length, left, right, runs)
    _set_edge(edges, edge + 1, a, length, right, left, runs)
    for end in range(2):
        node, other = (b, a) if end else (a, b)
        at = begins[node] + degrees[node]
        rows[at, NODE] = other
        rows[at, LENGTH_TO] = length
        rows[at, EDGE] = edge + end
        degrees[node] += 1
    state[EDGES] += 2


@bare
def _set_edge(edges: Rows, edge: int, to: int, length: int, left: int, right: int, runs: int) -> None:
    edges[edge, TO] = to
    edges[edge, LENGTH] = length
    edges[edge, LEFT] = left
    edges[edge, RIGHT] = right
    edges[edge, RUNS] = runs


@bare
def _index_of(node: int, other: int, begins: Words, degrees: Integers, rows: Rows) -> int:
    """Return the row of a neighbour of a node, or −1."""
    for at in range(begins[node], begins[node] + degrees[node]):
        if rows[at, NODE] == other:
            return at
    return -1


@bare
def _remove_neighbour(node: int, other: int, begins: Words, degrees: Integers, rows: Rows) -> None:
    """Remove a neighbour from the rows of a node."""
    at = _index_of(node, other, begins, degrees, rows)
    degrees[node] -= 1
    last = begins[node] + degrees[node]
    for column in range(3):
        rows[at, column] = rows[last, column]


@bare
def _enlarge_row(node: int, begins: Words, degrees: Integers, capacities: Integers, rows: Rows, state: Words) -> None:
    if degrees[node] < capacities[node]:
        return
    begin = state[USED]
    capacities[node] *= 2
    state[USED] += capacities[node]
    for i in range(degrees[node]):
        for column in range(3):
            rows[begin + i, column] = rows[begins[node] + i, column]
    begins[node] = begin


@bare
def _row_growth(node: int, begins: Words, degrees: Integers, capacities: Integers, rows: Rows) -> int:
    """Return an upper bound of the rows needed if all neighbours of a node become neighbours of each other."""
    growth = np.int64(0)
    for at in range(begins[node], begins[node] + degrees[node]):
        other = rows[at, NODE]
        if degrees[other] + degrees[node] > capacities[other]:
            growth += 4 * (capacities[other] + degrees[node])  # doubled until large enough
    return int(growth)


@bare
def _add_shortcut(
    left: int, right: int, begins: Words, degrees: Integers, capacities: Integers, rows: Rows, edges: Rows, state: Words
) -> None:
    """Add the shortcut between two neighbours of a node, given by their rows, or shorten their existing edge."""
    a, b, length = rows[left, NODE], rows[right, NODE], rows[left, LENGTH_TO] + rows[right, LENGTH_TO]
    first, second = rows[left, EDGE], rows[right, EDGE]
    runs = edges[first, RUNS] + edges[second, RUNS]
    at = _index_of(a, b, begins, degrees, rows)
    if at < 0:
        _enlarge_row(a, begins, degrees, capacities, rows, state)
        _enlarge_row(b, begins, degrees, capacities, rows, state)
        _add_edge_pair(a, b, length, first, second, runs, begins, degrees, rows, edges, state)
    elif length < rows[at, LENGTH_TO]:
        edge = rows[at, EDGE]
        _set_edge(edges, edge, b, length, first, second, runs)
        _set_edge(edges, edge ^ 1, a, length, second, first, runs)
        rows[at, LENGTH_TO] = rows[_index_of(b, a, begins, degrees, rows), LENGTH_TO] = length


@compiled
def contract(
    batch: Integers, pairs: Rows, counts: Rows,
    begins: Words, degrees: Integers, capacities: Integers, rows: Rows, edges: Rows,
    levels: Integers, contracted_nodes: Flags, in_round: Flags, order: Integers, state: Words, core: int, budget: int,
) -> bool:  # fmt: skip
    """Contract the nodes of a round, until the budget is used or memory is short; return whether all are done.

    Parameters
    ----------
    batch : (b,) int32 array
        Nodes of the round, not adjacent to each other.
    pairs, counts
        Necessary shortcuts of each node, from `shortcuts.find_shortcuts`.
    begins, degrees, capacities, rows, edges
        The graph, from `build_rows`.
    levels : (n,) int32 array
        Level of each node: above those of the neighbours contracted before it; zero at first.
    contracted_nodes, in_round : (n,) bool arrays
        Which nodes are contracted, and which belong to the round.
    order : (n,) int32 array
        Out: contracted nodes, in their order.
    state : (4,) int64 array
        Counters; `NEXT` is zero at the begin of a round.
    core : int
        Minimum number of nodes left.
    budget : int
        Limit of the work in this call.
    """
    work = 0
    while state[NEXT] < len(batch) and work < budget:
        node, found = batch[state[NEXT]], counts[state[NEXT], FOUND]
        slot, first, degree = counts[state[NEXT], SLOT], counts[state[NEXT], FIRST], degrees[node]
        # Stop if memory may be short.
        if state[EDGES] + 2 * found > len(edges):
            return False
        if state[USED] + _row_growth(node, begins, degrees, capacities, rows) > len(rows):
            return False
        in_round[node] = False
        state[NEXT] += 1
        work += 1
        if len(contracted_nodes) - state[CONTRACTED] <= core:
            continue
        begin = begins[node]
        # Remove the node from its neighbours.
        for at in range(begin, begin + degree):
            other = rows[at, NODE]
            _remove_neighbour(other, node, begins, degrees, rows)
            levels[other] = max(levels[other], levels[node] + 1)
        # Add shortcuts between its neighbours.
        for i in range(first, first + found):
            left, right = pairs[slot, i] >> PAIR_BITS, pairs[slot, i] & ((1 << PAIR_BITS) - 1)
            _add_shortcut(begin + left, begin + right, begins, degrees, capacities, rows, edges, state)
        contracted_nodes[node] = True
        order[state[CONTRACTED]] = node
        state[CONTRACTED] += 1
        work += degree * degree + found * degree
    return bool(state[NEXT] == len(batch))


@bare
def list_edges(begins: Words, degrees: Integers, rows: Rows, head: Integers, after: Integers) -> None:
    """Write linked lists of edges: the edges of a node from ``head`` on, linked by ``after``."""
    for node in range(len(begins)):
        head[node] = -1
        for at in range(begins[node], begins[node] + degrees[node]):
            after[rows[at, EDGE]] = head[node]
            head[node] = rows[at, EDGE]


def warm() -> None:
    """Compile and call each kernel once."""
    starts, to, lengths = np.array([0, 1, 2]), np.array([1, 0], np.int32), np.ones(2, np.int32)
    begins, numbers, state = np.zeros(2, np.int64), np.zeros((5, 2), np.int32), np.zeros(4, np.int64)
    rows, edges, flags = np.zeros((20, 3), np.int32), np.zeros((2, 5), np.int32), np.zeros((2, 2), np.bool_)
    build_rows(np.zeros((2, 2), np.int32), starts, to, lengths, begins, numbers[0], numbers[1], rows, edges, state)
    contract(
        numbers[3, :1], np.zeros((1, 1), np.int32), np.zeros((2, 3), np.int32),
        begins, numbers[0], numbers[1], rows, edges, numbers[4], flags[0], flags[1], lengths, state, 0, 1,
    )  # fmt: skip
    list_edges(begins, numbers[0], rows, numbers[2], numbers[3])
