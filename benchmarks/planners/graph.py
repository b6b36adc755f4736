"""Graph of all moves on a grid by our planners' definition, for general graph libraries."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.weights import SQRT2

_MOVES = ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1))


def edges_of(weights: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Return all moves away from the goal: flat indices of their source and target cells, and their costs.

    Parameters
    ----------
    weights : (height, width) array
        Weights of the cells, infinite if blocked. A move costs the weight of its target, which is farther from the
        goal.
    """
    free = np.isfinite(weights)
    padded = np.pad(free, 1)
    number = np.arange(weights.size).reshape(weights.shape)
    sources, targets, costs = [], [], []
    for down, right in _MOVES:
        is_open = free & _moved(padded, down, right)
        if down and right:
            is_open &= _moved(padded, down, 0) & _moved(padded, 0, right)
        source = number[is_open]
        target = source + down * weights.shape[1] + right
        sources.append(source)
        targets.append(target)
        costs.append(weights.ravel()[target] * (SQRT2 if down and right else 1.0))
    return np.concatenate(sources), np.concatenate(targets), np.concatenate(costs)


def graph_of(weights: NDArray[np.float64]) -> Any:
    """Return the graph as a sparse matrix for scipy's csgraph."""
    from scipy.sparse import coo_array  # noqa: PLC0415 - of the extra bench

    sources, targets, costs = edges_of(weights)
    return coo_array((costs, (sources, targets)), shape=(weights.size, weights.size)).tocsr()


def digraph_of(networkx: Any, weights: NDArray[np.float64]) -> Any:
    """Return the graph for networkx."""
    graph = networkx.DiGraph()
    graph.add_nodes_from(np.flatnonzero(np.isfinite(weights)).tolist())
    graph.add_weighted_edges_from(zip(*(ends.tolist() for ends in edges_of(weights)), strict=True))
    return graph


def _moved(padded: NDArray[np.bool_], down: int, right: int) -> NDArray[np.bool_]:
    """Return for each cell whether the cell at that offset is free."""
    height, width = padded.shape
    return padded[1 + down : height - 1 + down, 1 + right : width - 1 + right]
