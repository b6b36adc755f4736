"""Kernel: order of the contraction, in rounds of independent nodes with the lowest costs.

The cost of a node is twice its edge difference (shortcuts minus neighbours) plus its level. A round contracts the nodes
whose cost is below that of all their neighbours (Vetter, "Parallel Time-Dependent Contraction Hierarchies", 2009).
Witness paths must not use other nodes of the round, so omitted shortcuts stay unnecessary after it. Costs are updated
before a node is contracted. If that is expensive, short searches update the costs first, and only nodes that stay in
the round are searched fully.
"""

import numpy as np

from ppaas.kernel_cache.decorators import bare, joined
from ppaas.planners.hub_labels.building.kernels.contraction import FOUND, NODE, Flags
from ppaas.planners.hub_labels.building.kernels.trees import Rows
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.scan import Integers

BIAS = 1 << 20
"""Offset of costs, which keeps them positive."""

_HASH = 0x9E3779B1
"""Multiplier that hashes node numbers to break ties. In their own order, nodes would wait for each other."""


@joined
def _sort_key(node: int, cost: int) -> int:
    """Return the sort key of a node: its cost, then its hash."""
    return int((np.int64(cost) << 32) | ((np.int64(node) * _HASH) & 0xFFFFFFFF))


@bare
def _comes_first(node: int, begins: Words, degrees: Integers, rows: Rows, costs: Integers, most: int) -> bool:
    """Return whether the cost of a node is below that of all its neighbours."""
    key = _sort_key(node, costs[node])
    for at in range(begins[node], begins[node] + degrees[node]):
        other = rows[at, NODE]
        if degrees[other] <= most and _sort_key(other, costs[other]) < key:
            return False
    return True


@bare
def select_nodes(
    first: int, last: int, begins: Words, degrees: Integers, rows: Rows, costs: Integers, contracted_nodes: Flags,
    most: int, batch: Integers, count: int, in_round: Flags,
) -> int:  # fmt: skip
    """Select nodes for a round among those from ``first`` to ``last``; return the new number of nodes.

    Parameters
    ----------
    first, last : int
        Range of the nodes.
    begins, degrees, rows
        The graph, as in `contraction`.
    costs : (n,) int32 array
        Cost of each node.
    contracted_nodes : (n,) bool array
        Which nodes are contracted.
    most : int
        Largest number of neighbours of a contracted node.
    batch : (n,) int32 array
        Out: the nodes.
    count : int
        Number of nodes selected so far.
    in_round : (n,) bool array
        Out: True for selected nodes.
    """
    for node in range(first, last):
        if contracted_nodes[node] or degrees[node] > most:
            continue
        if _comes_first(node, begins, degrees, rows, costs, most):
            batch[count] = node
            in_round[node] = True
            count += 1
    return count


@bare
def confirm_nodes(
    batch: Integers, counts: Rows, first: int, last: int, kept: int,
    begins: Words, degrees: Integers, rows: Rows, levels: Integers, costs: Integers, most: int, in_round: Flags,
) -> int:  # fmt: skip
    """Update the costs of nodes of a round, and drop those that no longer come before all neighbours.

    Parameters
    ----------
    batch : (b,) int32 array
        The nodes. Out: confirmed nodes first.
    counts : (b, 3) int32 array
        Necessary shortcuts of each, from `shortcuts.find_shortcuts`. Out: those of confirmed nodes first.
    first, last : int
        Range of the batch to examine.
    kept : int
        Number of nodes confirmed so far.
    begins, degrees, rows
        The graph, as in `contraction`.
    levels : (n,) int32 array
        Level of each node.
    costs : (n,) int32 array
        Out: updated costs.
    most : int
        Largest number of neighbours of a contracted node.
    in_round : (n,) bool array
        Out: False for dropped nodes.

    Returns
    -------
    int
        New number of confirmed nodes.
    """
    for i in range(first, last):
        node = batch[i]
        costs[node] = 2 * (counts[i, FOUND] - degrees[node]) + levels[node] + BIAS
        in_round[node] = _comes_first(node, begins, degrees, rows, costs, most)
        if in_round[node]:
            batch[kept] = node
            for column in range(3):
                counts[kept, column] = counts[i, column]
            kept += 1
    return kept


def warm() -> None:
    """Compile and call each kernel once."""
    begins, numbers, rows = np.array([0, 1]), np.zeros((4, 2), np.int32), np.zeros((2, 3), np.int32)
    rows[:, NODE] = 1, 0
    numbers[0] = 1
    flags, counts = np.zeros((2, 2), np.bool_), np.zeros((2, 3), np.int32)
    chosen = select_nodes(0, 2, begins, numbers[0], rows, numbers[1], flags[0], 1, numbers[2], 0, flags[1])
    confirm_nodes(numbers[2], counts, 0, chosen, 0, begins, numbers[0], rows, numbers[3], numbers[1], 1, flags[1])
