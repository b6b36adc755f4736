"""Odometry chain of a pose graph: relative poses along the trajectory, and their covariances, for any two nodes."""

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.pose_graph import EdgeKind, Edges, PoseGraph
from ppaas.planar_poses import PoseArray, compose, relative, rotated

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

_LEAST_INFORMATION = 1e-6
"""Added to the diagonal of information matrices, so that singular ones have an inverse."""


class OdometryChain:
    """Poses by the odometry edges between consecutive nodes alone, with accumulated covariances.

    Covariances are of small motions after the pose, in its own frame; the adjoint of a pose carries them into another
    frame, in which the covariances of successive edges add (Barfoot, Furgale, *Associating uncertainty with
    three-dimensional poses*, T-RO 30(3), 2014, to first order).

    Parameters
    ----------
    graph : PoseGraph
        If several odometry edges connect two consecutive nodes, the first counts.
    """

    def __init__(self, graph: PoseGraph) -> None:
        edges = graph.edges
        following = (edges.kinds == EdgeKind.ODOMETRY) & (edges.second == edges.first + 1)
        count, links = graph.node_count, edges.take(np.flatnonzero(following)[::-1])
        steps, local = np.zeros((count, 3)), np.zeros((count, 3, 3))
        steps[links.second] = links.measurements
        local[links.second] = end_covariances(links)
        linked = np.zeros(count, np.bool_)
        linked[links.second] = True
        self.parts: Ints = np.cumsum(~linked)
        """Number of the unbroken chain that each node is in, (n,)."""
        self.poses: PoseArray = _accumulated(steps)
        """Poses of the nodes by odometry, (n, 3); each chain starts where the one before it ends."""
        carry = adjoints(self.poses)
        self._sums: Floats = np.cumsum(carry @ local @ np.swapaxes(carry, 1, 2), axis=0)

    def relative(self, first: Ints, second: Ints) -> PoseArray:
        """Return the poses of nodes in the frames of others."""
        return relative(self.poses[first], self.poses[second])

    def covariances(self, first: Ints, second: Ints) -> Floats:
        """Return the covariances (m, 3, 3) of those poses, as small motions in the frames of ``second``."""
        sums = self._sums[np.maximum(first, second)] - self._sums[np.minimum(first, second)]
        carry = adjoints(relative(self.poses[second], np.zeros(3)))
        covariances: Floats = carry @ sums @ np.swapaxes(carry, -1, -2)
        return covariances


def end_covariances(edges: Edges) -> Floats:
    """Return the covariances (m, 3, 3) of measurements, as small motions in the frames of the second nodes."""
    inverses: Floats = np.linalg.inv(edges.information + _LEAST_INFORMATION * np.eye(3)).astype(np.float64)
    return rotated(inverses, -edges.measurements[:, 2])


def adjoints(poses: PoseArray) -> Floats:
    """Return the adjoint matrices (…, 3, 3), which carry small motions from the frames at poses to the common frame."""
    c, s = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    matrices = np.zeros((*poses.shape, 3))
    matrices[..., 0, 0] = matrices[..., 1, 1] = c
    matrices[..., 0, 1], matrices[..., 1, 0] = -s, s
    matrices[..., 0, 2], matrices[..., 1, 2], matrices[..., 2, 2] = poses[..., 1], -poses[..., 0], 1.0
    return matrices


def _accumulated(steps: PoseArray) -> PoseArray:
    """Return the products of the first 1, 2, … steps, by doubling."""
    poses, reach = steps.copy(), 1
    while reach < len(poses):
        poses[reach:] = compose(poses[:-reach].copy(), poses[reach:])
        reach *= 2
    return poses
