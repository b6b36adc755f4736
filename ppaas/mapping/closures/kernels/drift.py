"""Kernel: uncertainty along the shortest paths of a pose graph, as sums of moments (Bosse et al., IJRR 2004, Atlas)."""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

MOMENTS = 9
"""Sums per node: length; length × x, y; length × xx, xy, yy; signed length; signed length × x, y."""


@compiled
def _push(keys: NDArray[np.float64], nodes: NDArray[np.int64], size: int, key: float, node: int) -> None:
    """Insert a node into a binary heap of ``size`` nodes."""
    i = size
    while i > 0 and keys[(i - 1) >> 1] > key:
        keys[i], nodes[i] = keys[(i - 1) >> 1], nodes[(i - 1) >> 1]
        i = (i - 1) >> 1
    keys[i], nodes[i] = key, node


@compiled
def _pop(keys: NDArray[np.float64], nodes: NDArray[np.int64], size: int) -> int:
    """Remove the node with the smallest key from a binary heap of ``size`` nodes, and return it."""
    found: int = nodes[0]
    key, node = keys[size - 1], nodes[size - 1]
    i = 0
    while 2 * i + 1 < size - 1:
        child = 2 * i + 1
        if child + 1 < size - 1 and keys[child + 1] < keys[child]:
            child += 1
        if keys[child] >= key:
            break
        keys[i], nodes[i] = keys[child], nodes[child]
        i = child
    keys[i], nodes[i] = key, node
    return found


@compiled
def path_moments(
    root: int,
    starts: NDArray[np.int64],
    neighbours: NDArray[np.int64],
    lengths: NDArray[np.float64],
    signs: NDArray[np.float64],
    positions: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return sums along the shortest path from a node to each node (Dijkstra).

    A step of length l at position p, the mean of its ends, adds l, l p and l p pᵀ: the variance of the heading that
    the step adds, and the first and second moment of the lever with which it moves what lies beyond.

    Parameters
    ----------
    root : int
        First node of all paths.
    starts : (n + 1,) int64 array
        First edge of each node; an edge occurs at both its ends.
    neighbours : (e,) int64 array
        Node at the other end of each edge.
    lengths : (e,) array
        Distance travelled along each edge [m].
    signs : (e,) array
        1 for a step of the odometry in the order of time, −1 against it, 0 for a closure.
    positions : (n, 2) array
        Positions of the nodes [m].

    Returns
    -------
    (n, MOMENTS) array
        Sums as in `MOMENTS`; the length is infinite for a node without a path.
    """
    n = starts.size - 1
    moments = np.zeros((n, MOMENTS))
    moments[:, 0] = np.inf
    moments[root, 0] = 0.0
    done = np.zeros(n, np.bool_)
    keys, nodes = np.empty(neighbours.size + 1), np.empty(neighbours.size + 1, np.int64)
    _push(keys, nodes, 0, 0.0, root)
    size = 1
    while size > 0:
        node = _pop(keys, nodes, size)
        size -= 1
        if done[node]:
            continue
        done[node] = True
        for e in range(starts[node], starts[node + 1]):
            other, length = neighbours[e], lengths[e]
            if moments[node, 0] + length >= moments[other, 0]:
                continue
            x = 0.5 * (positions[node, 0] + positions[other, 0])
            y = 0.5 * (positions[node, 1] + positions[other, 1])
            signed = signs[e] * length
            moments[other] = moments[node]
            moments[other, 0] += length
            moments[other, 1] += length * x
            moments[other, 2] += length * y
            moments[other, 3] += length * x * x
            moments[other, 4] += length * x * y
            moments[other, 5] += length * y * y
            moments[other, 6] += signed
            moments[other, 7] += signed * x
            moments[other, 8] += signed * y
            _push(keys, nodes, size, moments[other, 0], other)
            size += 1
    return moments


def warm() -> None:
    """Call the kernel once, so that it is compiled or loaded from the cache."""
    path_moments(0, np.array((0, 1, 2)), np.array((1, 0)), np.ones(2), np.array((1.0, -1.0)), np.zeros((2, 2)))
