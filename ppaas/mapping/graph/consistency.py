"""Pairwise consistency of closures: the largest set in which every two agree (Mangelson et al., ICRA 2018)."""

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.pose_graph import Edges, PoseGraph


def largest_consistent_set(graph: PoseGraph, closures: Edges, chi2: float = 11.34) -> NDArray[np.bool_]:
    """Return a mask (m,) of the closures in the largest set of closures that agree pairwise.

    Two closures agree if the loop along both and the odometry between their ends closes within the covariances.

    Parameters
    ----------
    graph : PoseGraph
        Its odometry edges connect the nodes; its closures are ignored.
    closures : Edges
        Candidates between nodes of the graph.
    chi2 : float
        Largest squared Mahalanobis distance of a loop; by default the 99 % quantile with three degrees of freedom.
    """
    raise NotImplementedError
