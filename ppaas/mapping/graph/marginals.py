"""Marginal covariances of a pose graph: the uncertainty of a node relative to another, for search windows."""

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.pose_graph import PoseGraph
from ppaas.mapping.graph.solver import Solution


class Marginals:
    """Covariances at a solution of a graph, from one factorisation.

    Parameters
    ----------
    graph : PoseGraph
    solution : Solution, optional
        Poses and weights to linearise with; by default the poses of the graph and weights of 1.
    """

    def __init__(self, graph: PoseGraph, solution: Solution | None = None) -> None:
        raise NotImplementedError

    def relative_to(self, node: int) -> NDArray[np.float64]:
        """Return the covariances (n, 3, 3) of all nodes' poses in the frame of a node.

        Covariances of nodes without a path to the node are infinite on the diagonal.
        """
        raise NotImplementedError
