"""Components of a pose graph: the nodes that edges connect."""

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.pose_graph import PoseGraph


def components(graph: PoseGraph) -> NDArray[np.int64]:
    """Return the component (n,) of each node, numbered from 0 in the order of their first nodes.

    Most edges join successive nodes: they make chains, and only the edges between chains are visited one by one.
    """
    edges = graph.edges
    low, high = np.minimum(edges.first, edges.second), np.maximum(edges.first, edges.second)
    starts = np.ones(graph.node_count, bool)
    starts[high[high - low == 1]] = False
    chains = np.cumsum(starts) - 1
    roots = list(range(int(starts.sum())))
    for ends in np.unique(np.column_stack((chains[low], chains[high])), axis=0).tolist():
        first, second = sorted(_root(roots, chain) for chain in ends)
        roots[second] = first
    of_chains = np.array([_root(roots, chain) for chain in range(len(roots))], np.int64)
    numbers: NDArray[np.int64] = np.unique(of_chains, return_inverse=True)[1].astype(np.int64)[chains]
    return numbers


def _root(roots: list[int], chain: int) -> int:
    while roots[chain] != chain:
        roots[chain] = chain = roots[roots[chain]]
    return chain
