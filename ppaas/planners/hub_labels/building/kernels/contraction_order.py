"""Kernel: the order in which nodes are contracted: round by round, those with the fewest shortcuts first.

Nodes go in rounds. In each, those go whose price is less than that of all their neighbours; `shortcuts` tells what
shortcuts they leave (Vetter, "Parallel Time-Dependent Contraction Hierarchies", 2009). Ways that lead over another
node of the same round do not count, so whatever is left out is a way over what is left. Prices are told again before
nodes go. Where that takes long, it is done by short searches, and only for nodes that still may go are ways looked for
as far as it is worth it.
"""

import numpy as np

from ppaas.planners.hub_labels.building.kernels.contraction import FOUND, NODE, Flags
from ppaas.planners.hub_labels.building.kernels.trees import Rows
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.kernels.jit_decorators import bare, joined

BIAS = 1 << 20
"""Added to prices, so that none is negative."""

_MIXED = 0x9E3779B1
"""What a node's number is multiplied with to choose among those of the same price: in their own order they would wait
for each other."""


@joined
def _turn(node: int, price: int) -> int:
    """Return what tells which of two nodes comes first."""
    return int((np.int64(price) << 32) | ((np.int64(node) * _MIXED) & 0xFFFFFFFF))


@bare
def _comes_first(node: int, begins: Words, degrees: Integers, rows: Rows, prices: Integers, most: int) -> bool:
    """Tell whether a node comes before all its neighbours."""
    turn = _turn(node, prices[node])
    for at in range(begins[node], begins[node] + degrees[node]):
        other = rows[at, NODE]
        if degrees[other] <= most and _turn(other, prices[other]) < turn:
            return False
    return True


@bare
def choose(
    first: int, last: int, begins: Words, degrees: Integers, rows: Rows, prices: Integers, gone: Flags,
    most: int, batch: Integers, count: int, held: Flags,
) -> int:  # fmt: skip
    """Choose nodes for a round among those from ``first`` to ``last``; return how many there are then.

    Parameters
    ----------
    first, last : int
    begins, degrees, rows
        The graph.
    prices : (n,) int32 array
    gone : (n,) bool array
        Which nodes were contracted.
    most : int
        Neighbours that a node may have to be contracted.
    batch : (n,) int32 array
        Out: the nodes.
    count : int
        How many there were before.
    held : (n,) bool array
        Out: true for each of them.
    """
    for node in range(first, last):
        if gone[node] or degrees[node] > most:
            continue
        if _comes_first(node, begins, degrees, rows, prices, most):
            batch[count] = node
            held[node] = True
            count += 1
    return count


@bare
def admit(
    batch: Integers, counts: Rows, first: int, last: int, kept: int,
    begins: Words, degrees: Integers, rows: Rows, levels: Integers, prices: Integers, most: int, held: Flags,
) -> int:  # fmt: skip
    """Tell anew what nodes of a round cost, and leave out those before which a neighbour comes then.

    Parameters
    ----------
    batch : (b,) int32 array
        The nodes; out: first those that are not left out.
    counts : (b, 3) int32 array
        What shortcuts each leaves, as `shortcuts.find_shortcuts` tells; out: likewise.
    first, last : int
        Which are to be looked at.
    kept : int
        How many of those before were not left out.
    begins, degrees, rows
        The graph.
    levels : (n,) int32 array
        How deep a node lies under those contracted before it.
    prices : (n,) int32 array
        Out: what it costs to contract them.
    most : int
        Neighbours that a node may have to be contracted.
    held : (n,) bool array
        Out: false for those that are left out.

    Returns
    -------
    int
        How many are not left out so far.
    """
    for i in range(first, last):
        node = batch[i]
        prices[node] = 2 * (counts[i, FOUND] - degrees[node]) + levels[node] + BIAS
        held[node] = _comes_first(node, begins, degrees, rows, prices, most)
        if held[node]:
            batch[kept] = node
            for what in range(3):
                counts[kept, what] = counts[i, what]
            kept += 1
    return kept


def warm() -> None:
    """Compile and call each kernel once."""
    begins, numbers, rows = np.array([0, 1]), np.zeros((4, 2), np.int32), np.zeros((2, 3), np.int32)
    rows[:, NODE] = 1, 0
    numbers[0] = 1
    flags, counts = np.zeros((2, 2), np.bool_), np.zeros((2, 3), np.int32)
    chosen = choose(0, 2, begins, numbers[0], rows, numbers[1], flags[0], 1, numbers[2], 0, flags[1])
    admit(numbers[2], counts, 0, chosen, 0, begins, numbers[0], rows, numbers[3], numbers[1], 1, flags[1])
