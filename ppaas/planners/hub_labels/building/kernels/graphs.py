"""Kernel: convert the linked lists of a contracted graph into contiguous edges, with nodes numbered by importance."""

import numpy as np

from ppaas.kernel_cache.decorators import bare
from ppaas.planners.hub_labels.building.kernels.contraction import LENGTH, TO
from ppaas.planners.hub_labels.building.kernels.trees import Rows
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.scan import Integers


@bare
def rank_edges(
    nodes: Integers, ranks: Integers, head: Integers, after: Integers, edges: Rows, starts: Words, to: Integers,
    far: Integers, ids: Integers,
) -> None:  # fmt: skip
    """Store the edges of nodes one after the other.

    Parameters
    ----------
    nodes : (k,) int32 array
        The nodes, the most important first.
    ranks : (n,) int32 array
        New number of each node.
    head, after, edges
        The contracted graph: first edge of each node, next edge of the same node, and edges as in `contraction`.
    starts : (k + 1,) int64 array
        Out: first edge of each node.
    to, far, ids : (m,) int32 arrays
        Out: end, length, and number in ``edges`` of each edge. If empty, edges are only counted.
    """
    at = 0
    starts[0] = 0
    for place in range(len(nodes)):
        edge = head[nodes[place]]
        while edge >= 0:
            if len(to):
                to[at] = ranks[edges[edge, TO]]
                far[at] = edges[edge, LENGTH]
                ids[at] = edge
            at += 1
            edge = after[edge]
        starts[place + 1] = at


def warm() -> None:
    """Compile and call each kernel once."""
    nothing = np.empty(0, np.int32)
    edges = np.empty((0, 5), np.int32)
    rank_edges(nothing, nothing, nothing, nothing, edges, np.zeros(1, np.int64), nothing, nothing, nothing)
