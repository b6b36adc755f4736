"""Kernel: the nearest of many poses, in buckets of the plane."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled


@compiled
def _bucket_of(value: float, low: float, edge: float, count: int) -> int:
    """Return the bucket of a coordinate, limited to those beside the buckets in use."""
    return min(max(math.floor((value - low) / edge), -1), count)


@compiled
def _insert(distances: NDArray[np.float64], found: NDArray[np.int64], distance: float, index: int) -> None:
    """Insert an index into the sorted rows of one query, whose last entry is dropped."""
    k = distances.size - 1
    while k > 0 and distances[k - 1] > distance:
        distances[k], found[k] = distances[k - 1], found[k - 1]
        k -= 1
    distances[k], found[k] = distance, index


@compiled
def nearest(
    queries: NDArray[np.float64], poses: NDArray[np.float64], count: int, radius: float, edge: float
) -> NDArray[np.int64]:
    """Return the nearest poses of each query; the distance is √(Δx² + Δy² + |Δ(cos θ, sin θ)|²), with 1 m per unit.

    Parameters
    ----------
    queries : (q, 3) float64 array
        x, y [m], theta [rad].
    poses : (n, 3) float64 array
        Poses to choose from.
    count : int
        Largest number of poses of each query.
    radius : float
        Largest distance [m].
    edge : float
        Edge of a bucket, at least ``radius`` [m].

    Returns
    -------
    (q, count) int64 array
        Indices of poses, nearest first; −1 where there are no more.
    """
    found = np.full((queries.shape[0], count), -1, np.int64)
    if poses.shape[0] == 0 or count == 0:
        return found
    # Buckets: a counting sort of the poses by row and column.
    x0, y0 = poses[:, 0].min(), poses[:, 1].min()
    columns = math.floor((poses[:, 0].max() - x0) / edge) + 1
    rows = math.floor((poses[:, 1].max() - y0) / edge) + 1
    begins = np.zeros(rows * columns + 1, np.int64)
    buckets = np.empty(poses.shape[0], np.int64)
    for i in range(poses.shape[0]):
        row, column = _bucket_of(poses[i, 1], y0, edge, rows), _bucket_of(poses[i, 0], x0, edge, columns)
        buckets[i] = row * columns + column
        begins[buckets[i] + 1] += 1
    begins = np.cumsum(begins)
    filled, order = begins.copy(), np.empty(poses.shape[0], np.int64)
    for i in range(poses.shape[0]):
        order[filled[buckets[i]]] = i
        filled[buckets[i]] += 1
    # The nearest poses of each query are in the 3 × 3 buckets around it.
    distances = np.empty(count)
    for q in range(queries.shape[0]):
        distances[:] = radius * radius
        row, column = _bucket_of(queries[q, 1], y0, edge, rows), _bucket_of(queries[q, 0], x0, edge, columns)
        for v in range(max(row - 1, 0), min(row + 2, rows)):
            for u in range(max(column - 1, 0), min(column + 2, columns)):
                for k in range(begins[v * columns + u], begins[v * columns + u + 1]):
                    i = order[k]
                    dx, dy = poses[i, 0] - queries[q, 0], poses[i, 1] - queries[q, 1]
                    squared = dx * dx + dy * dy
                    if squared < distances[count - 1]:
                        squared += 2.0 - 2.0 * math.cos(poses[i, 2] - queries[q, 2])
                        if squared < distances[count - 1]:
                            _insert(distances, found[q], squared, i)
    return found


def warm() -> None:
    """Call the kernel once, so that it is compiled or loaded from the cache."""
    nearest(np.zeros((1, 3)), np.zeros((1, 3)), 1, 1.0, 1.0)
