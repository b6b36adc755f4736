"""Twins of the kernels of the pose graph: dense matrices, and elimination with sets."""

import itertools
import math

import numpy as np

from ppaas.geometry import Pose2D, wrap_angle


def eliminated(count, pairs, order):
    """Return the neighbours that each node has when it is eliminated, by elimination on sets."""
    neighbours = [set() for _ in range(count)]
    for a, b in pairs:
        neighbours[a].add(b)
        neighbours[b].add(a)
    structure = []
    for node in order:
        members = neighbours[node]
        structure.append(set(members))
        for a, b in itertools.permutations(members, 2):
            neighbours[a].add(b)
        for a in members:
            neighbours[a].discard(node)
    return structure


def dense(diagonal, off_diagonal, first, second):
    """Return a block matrix as a dense one; block k of the pairs is in row ``second`` and column ``first``."""
    count = len(diagonal)
    matrix = np.zeros((count, 3, count, 3))
    for i in range(count):
        matrix[i, :, i] = diagonal[i]
    for block, i, j in zip(off_diagonal, first, second, strict=True):
        matrix[j, :, i] = block
        matrix[i, :, j] = block.T
    return matrix.reshape(3 * count, 3 * count)


def error_of(poses, first, second, measurement):
    """Return the error of an edge, with single poses."""
    seen = Pose2D(*poses[first]).inverse() @ Pose2D(*poses[second])
    x, y, theta = measurement
    return np.array([seen.x - x, seen.y - y, wrap_angle(seen.theta - theta)])


def derivatives(poses, first, second, step=1e-6):
    """Return the derivatives of an edge's error by both poses, by central differences."""
    columns = []
    for node, axis in itertools.product((first, second), range(3)):
        ahead, behind = poses.copy(), poses.copy()
        ahead[node, axis] += step
        behind[node, axis] -= step
        zero = (0.0, 0.0, 0.0)
        change = error_of(ahead, first, second, zero) - error_of(behind, first, second, zero)
        change[2] = wrap_angle(change[2])
        columns.append(change / (2 * step))
    return np.array(columns[:3]).T, np.array(columns[3:]).T


def normal_equations(poses, edges, weights, gradients=None):
    """Return H and b of all poses as dense arrays, edge by edge."""
    count = len(poses)
    matrix, right = np.zeros((count, 3, count, 3)), np.zeros((count, 3))
    for k, (i, j) in enumerate(zip(edges.first, edges.second, strict=True)):
        information = weights[k] * edges.information[k]
        error = error_of(poses, i, j, edges.measurements[k])
        slope = information @ error if gradients is None else weights[k] * gradients[k]
        by_pose = dict(zip((i, j), derivatives(poses, i, j), strict=True))
        for a, b in itertools.product((i, j), repeat=2):
            matrix[a, :, b] += by_pose[a].T @ information @ by_pose[b]
        for a in (i, j):
            right[a] += by_pose[a].T @ slope
    return matrix.reshape(3 * count, 3 * count), right.ravel()


def residuals(flat, edges, fixed, weights):
    """Return the whitened errors of all edges, for ``scipy.optimize.least_squares`` over the poses after the first."""
    poses = np.vstack([fixed, flat.reshape(-1, 3)])
    roots = np.linalg.cholesky(edges.information)
    parts = [
        math.sqrt(w) * root.T @ error_of(poses, i, j, z)
        for w, root, i, j, z in zip(weights, roots, edges.first, edges.second, edges.measurements, strict=True)
    ]
    return np.concatenate(parts)


def largest_clique_size(connected):
    """Return the size of a largest clique (Bron, Kerbosch, 1973)."""
    neighbours = [set(np.flatnonzero(row)) - {i} for i, row in enumerate(connected)]

    def extend(size, candidates):
        best = size
        for node in sorted(candidates):
            best = max(best, extend(size + 1, candidates & neighbours[node]))
            candidates = candidates - {node}
        return best

    return extend(0, set(range(len(connected))))
