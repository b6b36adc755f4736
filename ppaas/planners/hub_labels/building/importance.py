"""Importance of corners: contracted ones by contraction order, core ones by how many shortest paths they cover."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.hub_labels.building.graph import WORK_A_SLICE, ContractedGraph
from ppaas.planners.hub_labels.building.kernels.bucket_queue import ENTRY, buckets_for
from ppaas.planners.hub_labels.building.kernels.coverage import GROUPS, cover
from ppaas.planners.hub_labels.building.kernels.graphs import rank_edges
from ppaas.planners.hub_labels.building.kernels.trees import SETTLED, STATE, TREE, grow
from ppaas.planners.hub_labels.kernels import layout
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.scan import Integers

EDGES_A_SLICE = 3 << 16
"""Edges that a slot examines between two calls of ``check``: about five milliseconds, since all threads then wait for
each other."""

MOST_TREES = 600
"""Largest number of shortest-path trees in the sample."""

MOST_TREE_NODES = 1 << 22
"""Largest total number of their nodes."""


@dataclass(frozen=True, slots=True)
class RankedEdges:
    """Edges by node: edges of node i are at ``starts[i]:starts[i + 1]``.

    Parameters
    ----------
    starts : (n + 1,) int64 array
        First edge of each node.
    to, lengths, ids : (m,) int32 arrays
        End of each edge, its length, and its number in the contracted graph.
    """

    starts: Words
    to: Integers
    lengths: Integers
    ids: Integers


@dataclass(frozen=True, slots=True)
class ShortestPathTrees:
    """Shortest-path trees, one per row: parent, subtree size, first child, and next sibling of each node."""

    parents: Integers
    sizes: Integers
    firsts: Integers
    nexts: Integers


def edges_of(contracted: ContractedGraph, nodes: Integers, ranks: Integers) -> RankedEdges:
    """Return the edges of some nodes, with nodes numbered by ``ranks``."""
    starts, nothing = np.zeros(len(nodes) + 1, np.int64), np.empty(0, np.int32)
    graph = contracted.head, contracted.after, contracted.edges
    rank_edges(nodes, ranks, *graph, starts, nothing, nothing, nothing)
    to, lengths, ids = np.empty((3, starts[-1]), np.int32)
    if len(to):
        rank_edges(nodes, ranks, *graph, starts, to, lengths, ids)
    return RankedEdges(starts, to, lengths, ids)


def grow_trees(edges: RankedEdges, roots: Integers, *, threads: int, check: Callable[[], None]) -> ShortestPathTrees:
    """Return the shortest-path tree of each root."""
    nodes, rows, slots = len(edges.starts) - 1, len(roots), max(1, threads)
    states = np.zeros((slots, STATE), np.int64)
    states[:, TREE], states[:, SETTLED] = np.arange(slots), -1
    lengths, settled = np.empty((2, slots, nodes), np.int32)
    buckets = np.full((slots, buckets_for(int(edges.lengths.max(initial=0)))), -1, np.int32)
    entries = np.empty((slots, len(edges.to) + 1, ENTRY), np.int64)
    trees = ShortestPathTrees(*np.empty((4, rows, nodes), np.int32))
    while (states[:, TREE] < rows).any():
        check()
        grow(
            edges.starts, edges.to, edges.lengths, roots, states, lengths, buckets, entries, settled,
            trees.parents, trees.sizes, trees.firsts, trees.nexts, EDGES_A_SLICE, threads,
        )  # fmt: skip
    return trees


def order_core(edges: RankedEdges, *, threads: int, check: Callable[[], None]) -> NDArray[np.int32]:
    """Return the core nodes, the most important first."""
    nodes = len(edges.starts) - 1
    if nodes < 2:
        return np.arange(nodes, dtype=np.int32)
    count = min(nodes, MOST_TREES, max(16, MOST_TREE_NODES // nodes))
    roots = np.random.default_rng(nodes).permutation(nodes)[:count].astype(np.int32)
    trees = grow_trees(edges, roots, threads=threads, check=check)
    totals = np.column_stack([trees.sizes[group::GROUPS].sum(axis=0, dtype=np.int32) for group in range(GROUPS)])
    order, state = np.empty(nodes, np.int32), np.zeros(2, np.int64)
    done = False
    while not done:
        check()
        done = cover(
            trees.parents, trees.sizes, trees.firsts, trees.nexts, totals, order, state, WORK_A_SLICE
        )  # fmt: skip
    chosen = int(state[0])
    coverage = totals.sum(axis=1) - totals.max(axis=1)
    # Chosen nodes have totals of −1 and come last.
    order[chosen:] = np.argsort(-coverage, kind="stable")[: nodes - chosen]
    return order


def inherit(index: Words, positions: Integers) -> tuple[Integers, Integers]:
    """Return the importance of corners, taken from the index of nearly the same map.

    Parameters
    ----------
    index : int64 array
        Index of the earlier map.
    positions : (n, 2) int32 array
        Row and column of each current corner, row by row.

    Returns
    -------
    ranks : (n,) int32 array
        Earlier rank of each corner; −1 for new ones.
    costs : (n,) int32 array
        Costs that reproduce the contraction order: new corners first, core corners last.
    """
    before = int(index[layout.CORNERS])
    numbers = index.view(np.int32)
    table = numbers[2 * index[layout.TABLE] :][: before * layout.CORNER_SIZE].reshape(before, layout.CORNER_SIZE)
    ranks_before = numbers[2 * index[layout.RANKS] :][: before + 1]
    table = table[ranks_before[:before]]
    columns = max(int(side[:, 1].max(initial=0)) for side in (positions, table)) + 1
    keys, old_keys = (side[:, 0].astype(np.int64) * columns + side[:, 1] for side in (positions, table))
    found = np.minimum(np.searchsorted(old_keys, keys), max(before - 1, 0))
    ranks = np.full(len(positions), -1, np.int32)
    if before:
        same = old_keys[found] == keys
        ranks[same] = ranks_before[:before][found[same]]
    contracted = int(ranks_before[before])
    costs = np.where(ranks < 0, 0, np.minimum(before - ranks, contracted + 1)).astype(np.int32)
    return ranks, costs
