"""Marginal covariances of a pose graph: the uncertainty of a node relative to another, for search windows."""

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidGraph
from ppaas.mapping.graph.normal_equations import NormalEquations
from ppaas.mapping.graph.pose_graph import PoseGraph
from ppaas.mapping.graph.solver import Solution
from ppaas.planar_poses import PoseArray, relative

Floats = NDArray[np.float64]

_DAMPING = 1e-9
"""Added to the diagonal of the information, for nodes without information in some direction."""


class Marginals:
    """Covariances at a solution of a graph, from one factorisation.

    Parameters
    ----------
    graph : PoseGraph
    solution : Solution, optional
        Poses and weights to linearise with; by default the poses of the graph and weights of 1.

    Raises
    ------
    InvalidGraph
        The information of an edge is not positive definite.
    """

    def __init__(self, graph: PoseGraph, solution: Solution | None = None) -> None:
        edges = graph.edges
        self._poses: PoseArray = graph.poses.copy() if solution is None else solution.poses
        weights = np.ones(graph.edge_count) if solution is None else solution.weights
        self._equations = NormalEquations(graph.node_count, edges.first, edges.second)
        self._equations.linearise(self._poses, edges.information, np.zeros((graph.edge_count, 3)), weights)
        if self._equations.step(_DAMPING) is None:
            raise InvalidGraph("the edges do not determine the poses: an information matrix is not positive definite")
        self._own = self._equations.inverse_diagonal()

    def relative_to(self, node: int) -> Floats:
        """Return the covariances (n, 3, 3) of all nodes' poses in the frame of a node.

        Covariances of nodes without a path to the node are infinite on the diagonal.
        """
        count = len(self._poses)
        right = np.zeros((count, 3, 3))
        right[node] = np.eye(3)
        shared = self._equations.solve(right)
        j0, j1 = _derivatives(self._poses[node], self._poses)
        mixed = j1 @ shared @ np.swapaxes(j0, 1, 2)
        covariances: Floats = j0 @ self._own[node] @ np.swapaxes(j0, 1, 2) + j1 @ self._own @ np.swapaxes(j1, 1, 2)
        covariances += mixed + np.swapaxes(mixed, 1, 2)
        covariances[node] = 0.0
        covariances[self._equations.parts != self._equations.parts[node]] = np.diag(np.full(3, np.inf))
        return covariances


def _derivatives(pose: Floats, others: PoseArray) -> tuple[Floats, Floats]:
    """Return the derivatives (n, 3, 3) of the poses of ``others`` in the frame of a pose, by the pose and by them."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    seen = relative(pose, others)
    j0 = np.tile([[-c, -s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]], (len(others), 1, 1))
    j0[:, 0, 2], j0[:, 1, 2] = seen[:, 1], -seen[:, 0]
    return j0, np.tile([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]], (len(others), 1, 1))
