"""Drift: uncertainty of older key frames relative to the latest, along the shortest path of the pose graph.

The covariance along one path bounds the true one from above, as other paths only add information (Bosse et al., *SLAM
in Large-scale Cyclic Environments using the Atlas Framework*, IJRR 2004). Errors of the heading move all that lies
beyond, so the covariance is long across the path and narrow along it.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.closures.kernels.drift import path_moments
from ppaas.mapping.closures.parameters import DriftModel
from ppaas.mapping.closures.submaps import travelled
from ppaas.mapping.edge_information import determines_position
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges

CLOSURE_LENGTH = 0.2
"""Distance travelled that has the uncertainty of a closure [m]."""

LEAST_LENGTH = 1e-3
"""Least length of an edge [m]."""


def path_covariances(
    poses: NDArray[np.float64], edges: Edges, root: int, model: DriftModel
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the uncertainty of one node's pose, given each other node's pose.

    Parameters
    ----------
    poses : (n, 3) array
        Poses of the nodes.
    edges : Edges
        Edges of the graph. Closures that leave the position open in a direction, as along a corridor, are left
        out.
    root : int
        The node.
    model : DriftModel

    Returns
    -------
    (n, 3, 3) array
        Covariance of the root's x, y, theta in the map frame, if the other node is at its pose; infinite on the
        diagonal without a path.
    (n,) array
        Distance travelled along the path [m].
    """
    edges = edges.take((edges.kinds != EdgeKind.CLOSURE) | determines_position(edges.information))
    starts, neighbours, lengths, signs = _adjacency(len(poses), edges)
    moments = path_moments(root, starts, neighbours, lengths, signs, np.ascontiguousarray(poses[:, :2]))
    distance = moments[:, 0].copy()
    apart = np.isinf(distance)
    moments[apart] = 0.0
    covariances = _covariances(moments, poses[root, :2], model)
    covariances[apart] = np.diag(np.full(3, np.inf))
    return covariances, distance


def _adjacency(
    n: int, edges: Edges
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Return each node's edges in compressed rows: first edge of a node, other node, length and sign."""
    closure = edges.kinds == EdgeKind.CLOSURE
    length = np.where(closure, CLOSURE_LENGTH, np.maximum(travelled(edges.measurements), LEAST_LENGTH))
    sign = np.where(closure, 0.0, np.sign(edges.second - edges.first))
    ends = np.concatenate((edges.first, edges.second))
    order = np.argsort(ends, kind="stable")
    starts = np.zeros(n + 1, np.int64)
    np.cumsum(np.bincount(ends, minlength=n), out=starts[1:])
    others = np.concatenate((edges.second, edges.first))[order]
    return starts, others, np.tile(length, 2)[order], np.concatenate((sign, -sign))[order]


def _covariances(moments: NDArray[np.float64], at: NDArray[np.float64], model: DriftModel) -> NDArray[np.float64]:
    """Return covariances (n, 3, 3) at a position (2,) from the sums along the paths."""
    length, sx, sy, sxx, sxy, syy, signed, mx, my = moments.T
    x, y = at
    # Levers from the steps to the position: Σ l (p − q)(p − q)ᵀ; an error of the heading moves across the lever.
    lxx = length * x * x - 2.0 * x * sx + sxx
    lxy = length * x * y - x * sy - y * sx + sxy
    lyy = length * y * y - 2.0 * y * sy + syy
    walk = np.zeros((len(moments), 3, 3))
    walk[:, 0, 0], walk[:, 0, 1], walk[:, 1, 1] = lyy, -lxy, lxx
    walk[:, 0, 2], walk[:, 1, 2] = -(length * y - sy), length * x - sx
    walk[:, 2, 2] = length
    walk[:, 1, 0], walk[:, 2, 0], walk[:, 2, 1] = walk[:, 0, 1], walk[:, 0, 2], walk[:, 1, 2]
    # A systematic error adds the levers instead of their squares.
    bias = np.stack((-(signed * y - my), signed * x - mx, signed), axis=-1)
    own = model.translation_walk**2 * length + (model.translation_bias * length) ** 2
    covariances: NDArray[np.float64] = model.heading_walk**2 * walk
    covariances += model.heading_bias**2 * bias[:, :, None] * bias[:, None, :]
    covariances[:, 0, 0] += own
    covariances[:, 1, 1] += own
    return covariances
