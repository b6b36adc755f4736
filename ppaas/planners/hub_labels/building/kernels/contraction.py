"""Kernel: contract the graph of corners from its least important nodes on, as long as few ways lead through a node.

To contract a node is to take it out and to put a shortcut in for each pair of its neighbours that have no other way as
short (Geisberger, Sanders, Schultes and Delling, "Contraction Hierarchies", WEA 2008). The nodes with the fewest
shortcuts go first, as `contraction_order` has it. What is left, nodes with many neighbours each, is called the core.

Edges come in pairs: e leads from a to b, e ^ 1 from b to a. A shortcut knows the two edges that it stands for, both
from the node that was contracted: ``left`` to its own beginning, ``right`` to its end; −1 and −1 in an edge of the
graph itself. ``runs`` is of how many runs it is when it is spelt out. The neighbours of a node lie side by side in
rows; one that is full is moved to the end, with room for twice as many.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.planners.hub_labels.building.kernels.trees import Rows
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import MOST_MOVES
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.kernels.jit_decorators import bare, joined

Flags = NDArray[np.bool_]

TO, LENGTH, LEFT, RIGHT, RUNS = range(5)

NODE, FAR_OFF, EDGE = range(3)
"""What a row tells of a neighbour: which node, how far, and the edge there."""

FIRST_ROOM = 8

PAIR_BITS = 16
"""A pair of neighbours is a number: the place of the second in the row, and above it that of the first."""

FOUND, FIRST, SLOT = range(3)
"""What is told of a node of a round: how many pairs of neighbours need a shortcut, where they begin, and which slot has
them."""

EDGES, CONTRACTED, USED, NEXT = range(4)
"""What is counted in ``state``: edges, nodes contracted, room that rows take, and nodes of this round that are done."""


@bare
def lay_rows(
    places: Rows, starts: Words, to: Integers, lengths: Integers,
    begins: Words, degrees: Integers, rooms: Integers, rows: Rows, edges: Rows, state: Words,
) -> None:  # fmt: skip
    """Lay the neighbours of each node side by side.

    Parameters
    ----------
    places : (n, 2) int32 array
        Row and column of each node.
    starts, to, lengths
        For each node where its edges begin, and for each edge where it leads and how long it is: both directions.
    begins : (n,) int64 array
    degrees, rooms : (n,) int32 arrays
        Out: where the row of a node begins, how many neighbours it has, and how many may have.
    rows : (k, 3) int32 array
        Out: of each neighbour `NODE`, `FAR_OFF` and `EDGE`.
    edges : (m, 5) int32 array
        Out: of each edge `TO` which node it leads, its `LENGTH`, `LEFT`, `RIGHT` and `RUNS`.
    state : (4,) int64 array
        Zeros at first.
    """
    for node in range(len(begins)):
        begins[node] = state[USED]
        rooms[node] = FIRST_ROOM + starts[node + 1] - starts[node]
        state[USED] += rooms[node]
    for node in range(len(begins)):
        for i in range(starts[node], starts[node + 1]):
            if to[i] > node:
                down, right = abs(places[node, 0] - places[to[i], 0]), abs(places[node, 1] - places[to[i], 1])
                runs = _runs_of(min(down, right)) + _runs_of(abs(down - right))
                _link(node, to[i], lengths[i], -1, -1, runs, begins, degrees, rows, edges, state)


@joined
def _runs_of(moves: int) -> int:
    return (moves + MOST_MOVES - 1) // MOST_MOVES


@bare
def _link(
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
        rows[at, FAR_OFF] = length
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
def _place_of(node: int, other: int, begins: Words, degrees: Integers, rows: Rows) -> int:
    """Return where a neighbour stands in the row of a node, or −1."""
    for at in range(begins[node], begins[node] + degrees[node]):
        if rows[at, NODE] == other:
            return at
    return -1


@bare
def _leave(node: int, other: int, begins: Words, degrees: Integers, rows: Rows) -> None:
    """Take a neighbour out of the row of a node."""
    at = _place_of(node, other, begins, degrees, rows)
    degrees[node] -= 1
    last = begins[node] + degrees[node]
    for what in range(3):
        rows[at, what] = rows[last, what]


@bare
def _widen(node: int, begins: Words, degrees: Integers, rooms: Integers, rows: Rows, state: Words) -> None:
    if degrees[node] < rooms[node]:
        return
    begin = state[USED]
    rooms[node] *= 2
    state[USED] += rooms[node]
    for i in range(degrees[node]):
        for what in range(3):
            rows[begin + i, what] = rows[begins[node] + i, what]
    begins[node] = begin


@bare
def _most_room(node: int, begins: Words, degrees: Integers, rooms: Integers, rows: Rows) -> int:
    """Return how much room the rows of a node's neighbours may take more, if each has all others as neighbours then."""
    room = np.int64(0)
    for at in range(begins[node], begins[node] + degrees[node]):
        other = rows[at, NODE]
        if degrees[other] + degrees[node] > rooms[other]:
            room += 4 * (rooms[other] + degrees[node])  # it is doubled until it is wide enough
    return int(room)


@bare
def _shorten(
    left: int, right: int, begins: Words, degrees: Integers, rooms: Integers, rows: Rows, edges: Rows, state: Words
) -> None:
    """Put the shortcut in that stands for two neighbours of one node, given where they stand in its row."""
    a, b, length = rows[left, NODE], rows[right, NODE], rows[left, FAR_OFF] + rows[right, FAR_OFF]
    first, second = rows[left, EDGE], rows[right, EDGE]
    runs = edges[first, RUNS] + edges[second, RUNS]
    at = _place_of(a, b, begins, degrees, rows)
    if at < 0:
        _widen(a, begins, degrees, rooms, rows, state)
        _widen(b, begins, degrees, rooms, rows, state)
        _link(a, b, length, first, second, runs, begins, degrees, rows, edges, state)
    elif length < rows[at, FAR_OFF]:
        edge = rows[at, EDGE]
        _set_edge(edges, edge, b, length, first, second, runs)
        _set_edge(edges, edge ^ 1, a, length, second, first, runs)
        rows[at, FAR_OFF] = rows[_place_of(b, a, begins, degrees, rows), FAR_OFF] = length


@njit(cache=True, nogil=True, error_model="numpy")
def contract(
    batch: Integers, pairs: Rows, counts: Rows,
    begins: Words, degrees: Integers, rooms: Integers, rows: Rows, edges: Rows,
    levels: Integers, gone: Flags, held: Flags, order: Integers, state: Words, core: int, budget: int,
) -> bool:  # fmt: skip
    """Contract the nodes of a round until so much was done, or there is no room for more; return whether all are done.

    Parameters
    ----------
    batch : (b,) int32 array
    pairs, counts
        What shortcuts they leave, as `shortcuts.find_shortcuts` tells.
    begins, degrees, rooms, rows, edges
        The graph.
    levels : (n,) int32 array
        How deep a node lies under those contracted before it; zero at first.
    gone, held : (n,) bool arrays
        Which nodes were contracted, and which belong to the round.
    order : (n,) int32 array
        Out: the nodes as they were contracted.
    state : (4,) int64 array
    core : int
        How many nodes are left at least.
    budget : int
    """
    work = 0
    while state[NEXT] < len(batch) and work < budget:
        node, found = batch[state[NEXT]], counts[state[NEXT], FOUND]
        slot, first, degree = counts[state[NEXT], SLOT], counts[state[NEXT], FIRST], degrees[node]
        if state[EDGES] + 2 * found > len(edges):
            return False
        if state[USED] + _most_room(node, begins, degrees, rooms, rows) > len(rows):
            return False
        held[node] = False
        state[NEXT] += 1
        work += 1
        if len(gone) - state[CONTRACTED] <= core:
            continue
        begin = begins[node]
        for at in range(begin, begin + degree):
            other = rows[at, NODE]
            _leave(other, node, begins, degrees, rows)
            levels[other] = max(levels[other], levels[node] + 1)
        for i in range(first, first + found):
            left, right = pairs[slot, i] >> PAIR_BITS, pairs[slot, i] & ((1 << PAIR_BITS) - 1)
            _shorten(begin + left, begin + right, begins, degrees, rooms, rows, edges, state)
        gone[node] = True
        order[state[CONTRACTED]] = node
        state[CONTRACTED] += 1
        work += degree * degree + found * degree
    return bool(state[NEXT] == len(batch))


@bare
def list_edges(begins: Words, degrees: Integers, rows: Rows, head: Integers, after: Integers) -> None:
    """Make linked lists of rows: the edges of a node are from ``head`` on by ``after``."""
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
    lay_rows(np.zeros((2, 2), np.int32), starts, to, lengths, begins, numbers[0], numbers[1], rows, edges, state)
    contract(
        numbers[3, :1], np.zeros((1, 1), np.int32), np.zeros((2, 3), np.int32),
        begins, numbers[0], numbers[1], rows, edges, numbers[4], flags[0], flags[1], lengths, state, 0, 1,
    )  # fmt: skip
    list_edges(begins, numbers[0], rows, numbers[2], numbers[3])
