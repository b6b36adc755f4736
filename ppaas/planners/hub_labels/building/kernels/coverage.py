"""Kernel: order nodes by how many shortest paths of a sample they cover, not counting paths through earlier nodes.

A node near the root of a tree is on most of its paths, however unimportant it is. So paths are counted by groups of
trees, and the group with the highest count of a node is ignored. Once the best node covers fewer paths than there are
trees, the sample gives no more information, and all other nodes are ordered by their current counts.

Source: Delling, Goldberg, Pajor and Werneck, "Robust Distance Queries on Massive Networks", ESA 2014.
"""

import numpy as np

from ppaas.kernel_cache.decorators import bare, compiled, joined
from ppaas.planners.hub_labels.building.kernels.trees import Rows
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.scan import Integers

GROUPS = 16
"""Number of groups; tree i belongs to group i mod `GROUPS`."""


@bare
def _remove_subtree(
    node: int, tree: int, parents: Rows, sizes: Rows, firsts: Rows, nexts: Rows, totals: Rows, stack: Integers
) -> int:
    """Remove all paths through a node from a tree, and return the number of nodes touched."""
    size, group = sizes[tree, node], tree % GROUPS
    touched = 0
    above = parents[tree, node]
    # Ancestors lose the paths of the subtree.
    while above >= 0 and sizes[tree, above] > 0:
        sizes[tree, above] -= size
        totals[above, group] -= size
        above = parents[tree, above]
        touched += 1
    # Descendants are not covered any more.
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
def _coverage(node: int, totals: Rows) -> int:
    """Return the number of paths through a node, without its highest group."""
    paths, most = np.int32(0), np.int32(0)
    for group in range(GROUPS):
        paths += totals[node, group]
        most = max(most, totals[node, group])
    return int(paths - most)


@bare
def _best(totals: Rows) -> int:
    best, most = 0, -1
    for node in range(len(totals)):
        coverage = _coverage(node, totals)
        if coverage > most:
            best, most = node, coverage
    return best


@compiled
def cover(
    parents: Rows, sizes: Rows, firsts: Rows, nexts: Rows, totals: Rows, order: Integers, state: Words, budget: int
) -> bool:
    """Choose nodes until the budget is used or no good node is left; return whether the choice is complete.

    Parameters
    ----------
    parents, sizes, firsts, nexts : (k, n) int32 arrays
        Shortest-path trees, as in `trees.grow`. ``sizes`` is updated to count the remaining paths.
    totals : (n, `GROUPS`) int32 array
        Sum of ``sizes`` over the trees of each group; −1 for chosen nodes.
    order : (n,) int32 array
        Out: chosen nodes, the one with the most paths first.
    state : (2,) int64 array
        Number of chosen nodes, and number of trees from which the paths of the next one are removed; zero at first.
    budget : int
        Limit of the work in this call.
    """
    stack = np.empty(len(totals), np.int32)
    work = 0
    while state[0] < len(totals) and work < budget:
        if state[1] == 0:
            best = _best(totals)
            if _coverage(best, totals) < len(parents):
                return True
            order[state[0]] = best
        best = order[state[0]]
        while state[1] < len(parents) and work < budget:
            if sizes[state[1], best] > 0:
                work += _remove_subtree(best, state[1], parents, sizes, firsts, nexts, totals, stack)
            work += 1
            state[1] += 1
        if state[1] == len(parents):
            totals[best] = -1
            state[0] += 1
            state[1] = 0
            # Counts the scan in `_best`, afterwards: else a small budget would never reach a tree.
            work += len(totals)
    return bool(state[0] == len(totals))


def warm() -> None:
    """Compile and call each kernel once."""
    rows = np.zeros((1, 1), np.int32)
    cover(rows, rows, rows, rows, np.zeros((1, GROUPS), np.int32), rows[0], np.zeros(2, np.int64), 1)
