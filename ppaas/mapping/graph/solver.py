"""Solver for pose graphs: the poses that fit the measurements best, with doubtful closures given less weight."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.pose_graph import PoseGraph
from ppaas.mapping.planar_poses import PoseArray


class Robust(Enum):
    """Method that reduces the weight of closures that contradict the other edges."""

    NONE = "none"
    """Least squares; every weight is 1."""
    SCALING = "scaling"
    """Dynamic covariance scaling (Agarwal et al., ICRA 2013); needs poses near the solution."""
    GRADUATED = "graduated"
    """Graduated non-convexity with truncated least squares (Yang et al., RA-L 2020); needs no good start."""


@dataclass(frozen=True)
class SolverOptions:
    """Options of a solve.

    Attributes
    ----------
    robust : Robust
    iterations : int
        Largest number of linear solves.
    tolerance : float
        A solve ends when no pose moves more than this [m, rad].
    closure_chi2 : float
        Squared Mahalanobis distance at which a closure starts to lose weight (scaling), or above which it is an
        outlier (graduated). The default is the 99 % quantile with three degrees of freedom.
    """

    robust: Robust = Robust.SCALING
    iterations: int = 30
    tolerance: float = 1e-4
    closure_chi2: float = 11.34


@dataclass(frozen=True)
class Solution:
    """Result of a solve.

    Attributes
    ----------
    poses : (n, 3) array
        x, y [m], theta [rad] of each node; node 0 has not moved.
    chi2 : (m,) array
        Squared Mahalanobis distance of each edge's measurement from these poses.
    weights : (m,) array
        Weight of each edge in [0, 1]: 1 for a trusted one, 0 for an outlier.
    iterations : int
        Number of linear solves.
    converged : bool
        Whether the last step was within the tolerance.
    """

    poses: PoseArray
    chi2: NDArray[np.float64]
    weights: NDArray[np.float64]
    iterations: int
    converged: bool


class GraphSolver:
    """Solves a growing pose graph; keeps the ordering and the pattern between solves of the same edges."""

    def solve(self, graph: PoseGraph, options: SolverOptions = SolverOptions()) -> Solution:
        """Return the most likely poses of a graph, starting from its poses. The graph is left unchanged.

        The first node of each connected part stays fixed.
        """
        raise NotImplementedError
