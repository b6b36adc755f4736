"""Kernels: errors of edges, and the normal equations of linearised edges.

The error of an edge is the pose of its second node in the frame of its first, minus the measurement; the angle is
wrapped. Poses change by addition to x, y, theta.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


@compiled
def edge_errors(
    poses: Floats, first: Ints, second: Ints, measurements: Floats, information: Floats, errors: Floats, chi2: Floats
) -> None:
    """Compute the errors of edges, and their squared Mahalanobis lengths.

    Parameters
    ----------
    poses : (n, 3) array
        x, y [m], theta [rad] of the nodes.
    first, second : (m,) array
        Nodes of the edges.
    measurements, information : (m, 3), (m, 3, 3) array
        Measurements, and their information in the frame of the first node.
    errors, chi2 : (m, 3), (m,) array
        Results.
    """
    for k in range(first.size):
        i, j = first[k], second[k]
        c, s = math.cos(poses[i, 2]), math.sin(poses[i, 2])
        x, y = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
        errors[k, 0] = c * x + s * y - measurements[k, 0]
        errors[k, 1] = c * y - s * x - measurements[k, 1]
        turn = poses[j, 2] - poses[i, 2] - measurements[k, 2]
        errors[k, 2] = (turn + math.pi) % (2.0 * math.pi) - math.pi
        chi2[k] = 0.0
        for a in range(3):
            for b in range(3):
                chi2[k] += errors[k, a] * information[k, a, b] * errors[k, b]


@compiled
def add_edges(
    poses: Floats,
    first: Ints,
    second: Ints,
    hessians: Floats,
    gradients: Floats,
    weights: Floats,
    rows: Ints,
    slots: Ints,
    diagonal: Floats,
    off_diagonal: Floats,
    right: Floats,
) -> None:
    """Add linearised edges to the normal equations H d = −b of the poses.

    Parameters
    ----------
    poses, first, second : array
        As for ``edge_errors``.
    hessians, gradients : (m, 3, 3), (m, 3) array
        Second and first derivatives of half the squared error of each edge by the relative pose of its nodes.
    weights : (m,) array
        Factors of both.
    rows : (n,) array
        Block row of each node; −1 for a fixed node.
    slots : (m,) array
        Block outside the diagonal of each edge, its row that of the second node; the complement ~k if its row is that
        of the first node; any number if a node is fixed.
    diagonal, off_diagonal, right : (f, 3, 3), (o, 3, 3), (f, 3) array
        Blocks of H, and b; changed.
    """
    # Derivatives of the relative pose by the first pose (j0) and by the second (j1).
    j0, j1, product = np.zeros((3, 3)), np.zeros((3, 3)), np.empty((3, 3))
    j0[2, 2], j1[2, 2] = -1.0, 1.0
    for k in range(first.size):
        if weights[k] == 0.0:
            continue
        i, j = rows[first[k]], rows[second[k]]
        pose, other = poses[first[k]], poses[second[k]]
        c, s = math.cos(pose[2]), math.sin(pose[2])
        x, y = other[0] - pose[0], other[1] - pose[1]
        j1[0, 0], j1[0, 1], j1[1, 0], j1[1, 1] = c, s, -s, c
        j0[0, 0], j0[0, 1], j0[1, 0], j0[1, 1] = -c, -s, s, -c
        j0[0, 2], j0[1, 2] = c * y - s * x, -(c * x + s * y)
        if i >= 0:
            _multiply(hessians[k], j0, weights[k], product)
            _add_transposed_product(j0, product, diagonal[i])
            _add_transposed_vector(j0, gradients[k], weights[k], right[i])
        if i >= 0 and j >= 0:
            if slots[k] >= 0:
                _add_transposed_product(j1, product, off_diagonal[slots[k]])
            else:
                _multiply(hessians[k], j1, weights[k], product)
                _add_transposed_product(j0, product, off_diagonal[~slots[k]])
        if j >= 0:
            _multiply(hessians[k], j1, weights[k], product)
            _add_transposed_product(j1, product, diagonal[j])
            _add_transposed_vector(j1, gradients[k], weights[k], right[j])


@compiled
def _multiply(left: Floats, right: Floats, factor: float, product: Floats) -> None:
    for a in range(3):
        for b in range(3):
            product[a, b] = factor * (left[a, 0] * right[0, b] + left[a, 1] * right[1, b] + left[a, 2] * right[2, b])


@compiled
def _add_transposed_product(left: Floats, right: Floats, total: Floats) -> None:
    for a in range(3):
        for b in range(3):
            total[a, b] += left[0, a] * right[0, b] + left[1, a] * right[1, b] + left[2, a] * right[2, b]


@compiled
def _add_transposed_vector(left: Floats, vector: Floats, factor: float, total: Floats) -> None:
    for a in range(3):
        total[a] += factor * (left[0, a] * vector[0] + left[1, a] * vector[1] + left[2, a] * vector[2])


@compiled
def connected_parts(count: int, first: Ints, second: Ints) -> Ints:
    """Return the smallest node of the connected part that each of ``count`` nodes is in (union-find, path halving)."""
    roots = np.arange(count)
    for k in range(first.size):
        a, b = first[k], second[k]
        while roots[a] != a:
            roots[a] = roots[roots[a]]
            a = roots[a]
        while roots[b] != b:
            roots[b] = roots[roots[b]]
            b = roots[b]
        roots[max(a, b)] = min(a, b)
    for i in range(count):
        roots[i] = roots[roots[i]]
    return roots


def warm() -> None:
    """Call the kernels once, so that they are compiled or loaded from the cache."""
    poses, first, second = np.zeros((2, 3)), np.zeros(1, np.int64), np.ones(1, np.int64)
    measurements, information = np.zeros((1, 3)), np.eye(3)[np.newaxis]
    ends = first.copy(), second.copy()
    for array in (first, second, measurements, information):
        array.flags.writeable = False  # as those of a pose graph
    edge_errors(poses, first, second, measurements, information, np.zeros((1, 3)), np.zeros(1))
    rows, slots, blocks = np.array((-1, 0)), np.zeros(1, np.int64), np.zeros((1, 3, 3))
    for hessians in (information, information.copy()):
        add_edges(
            poses, *ends, hessians, np.zeros((1, 3)), np.ones(1), rows, slots, blocks, blocks.copy(), np.zeros((1, 3))
        )
    connected_parts(2, *ends)
