"""Kernel: order nodes by how many shortest ways of a sample lead through them, ways through nodes before not counted.

A node near the root of a tree is on most ways of that tree, however unimportant it is. So ways are counted by groups of
trees, and the group with the most of a node's does not count. What is left of the trees soon tells nothing more: once
the best node is on fewer ways than there are trees, all others follow by the ways on which they are then.

Source: Delling, Goldberg, Pajor and Werneck, "Robust Distance Queries on Massive Networks", ESA 2014.
"""

import numpy as np
from numba import njit

from ppaas.planners.hub_labels.building.kernels.trees import Rows
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.kernels.jit_decorators import bare, joined

GROUPS = 16
"""Tree i belongs to the group i mod `GROUPS`."""


@bare
def _uncover(
    node: int, tree: int, parents: Rows, sizes: Rows, firsts: Rows, nexts: Rows, totals: Rows, stack: Integers
) -> int:
    """Take out of a tree all ways that lead through a node, and return how many nodes were touched."""
    size, group = sizes[tree, node], tree % GROUPS
    touched = 0
    above = parents[tree, node]
    while above >= 0 and sizes[tree, above] > 0:
        sizes[tree, above] -= size
        totals[above, group] -= size
        above = parents[tree, above]
        touched += 1
    stack[0] = node
    depth = 1
    while depth > 0:
        depth -= 1
        here = stack[depth]
        totals[here, group] -= sizes[tree, here]
        sizes[tree, here] = 0
        touched += 1
        child = firsts[tree, here]
        while child >= 0:
            if sizes[tree, child] > 0:
                stack[depth] = child
                depth += 1
            child = nexts[tree, child]
    return touched


@joined
def _worth(node: int, totals: Rows) -> int:
    """Return on how many ways a node is, without the group where it is on the most."""
    ways, most = np.int32(0), np.int32(0)
    for group in range(GROUPS):
        ways += totals[node, group]
        most = max(most, totals[node, group])
    return int(ways - most)


@bare
def _best(totals: Rows) -> int:
    best, most = 0, -1
    for node in range(len(totals)):
        worth = _worth(node, totals)
        if worth > most:
            best, most = node, worth
    return best


@njit(cache=True, nogil=True, error_model="numpy")
def cover(
    parents: Rows, sizes: Rows, firsts: Rows, nexts: Rows, totals: Rows, order: Integers, state: Words, budget: int
) -> bool:
    """Choose nodes until so many were touched, or there is no good one; return whether there is none.

    Parameters
    ----------
    parents, sizes, firsts, nexts : (k, n) int32 arrays
        Trees of shortest ways. Of ``sizes`` only the ways that are left.
    totals : (n, `GROUPS`) int32 array
        The sums of ``sizes`` over the trees of each group; −1 for a node that was chosen.
    order : (n,) int32 array
        Out: the nodes that were chosen, the one on the most ways first.
    state : (2,) int64 array
        How many are chosen, and of how many trees the ways of the next one were taken out; zeros at first.
    budget : int
    """
    stack = np.empty(len(totals), np.int32)
    work = 0
    while state[0] < len(totals) and work < budget:
        if state[1] == 0:
            best = _best(totals)
            if _worth(best, totals) < len(parents):
                return True
            order[state[0]] = best
        best = order[state[0]]
        while state[1] < len(parents) and work < budget:
            if sizes[state[1], best] > 0:
                work += _uncover(best, state[1], parents, sizes, firsts, nexts, totals, stack)
            work += 1
            state[1] += 1
        if state[1] == len(parents):
            totals[best] = -1
            state[0] += 1
            state[1] = 0
            work += len(totals)  # for the look at all of them; not before, or a small budget never came to a tree
    return bool(state[0] == len(totals))


def warm() -> None:
    """Compile and call each kernel once."""
    rows = np.zeros((1, 1), np.int32)
    cover(rows, rows, rows, rows, np.zeros((1, GROUPS), np.int32), rows[0], np.zeros(2, np.int64), 1)
