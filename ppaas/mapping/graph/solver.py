"""Solver for pose graphs: the poses that fit the measurements best, with doubtful closures given less weight."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.minimisation import Minimisation
from ppaas.mapping.graph.normal_equations import NormalEquations
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.graph.robust_weights import CovarianceScaling, FixedWeights, WeightRule, truncated_weights
from ppaas.planar_poses import PoseArray, wrap_angles

_CONTROL_FACTOR, _LAST_CONTROL = 10.0, 1.0
"""Factor of the control parameter of graduated non-convexity after a step, and its value at which scaling takes over.

The paper takes 1.4 and stops when all weights are 0 or 1. Factors of 1.4 to 10 led to the same solutions of walks of
1,500 nodes with 20 and 200 false closures among 2,500 true ones, in 55 to 22 solves.
"""

_FIRST_SOLVES = 2
"""Linear solves with all closures before the first of them loses weight."""


class Robust(Enum):
    """Method that reduces the weight of closures that contradict the other edges."""

    NONE = "none"
    """Least squares; every weight is 1."""
    SCALING = "scaling"
    """Dynamic covariance scaling (Agarwal et al., ICRA 2013); needs poses near the solution."""
    GRADUATED = "graduated"
    """Graduated non-convexity with truncated least squares (Yang et al., RA-L 2020), which needs no good start; then
    scaling, so that inliers near the limit keep a part of their weight."""


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
    iterations: int = 100
    tolerance: float = 1e-4
    closure_chi2: float = 11.34


@dataclass(frozen=True)
class Solution:
    """Result of a solve.

    Attributes
    ----------
    poses : (n, 3) array
        x, y [m], theta [rad] of each node; fixed nodes have not moved.
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


_DEFAULTS = SolverOptions()


class GraphSolver:
    """Solves a growing pose graph; keeps the ordering and the pattern between solves of the same edges.

    Parameters
    ----------
    fixed : sequence of int
        Nodes that keep their poses.
    """

    def __init__(self, fixed: Sequence[int] = ()) -> None:
        self._fixed = tuple(fixed)
        self._equations: NormalEquations | None = None

    def solve(self, graph: PoseGraph, options: SolverOptions = _DEFAULTS) -> Solution:
        """Return the most likely poses of a graph, starting from its poses. The graph is left unchanged.

        Fixed nodes stay, and so does the first node of each connected part that has none.
        """
        edges = graph.edges
        search = Minimisation(graph.poses.copy(), edges, self._equations_of(graph))
        closures = edges.kinds == EdgeKind.CLOSURE
        if options.robust is Robust.GRADUATED:
            rule, converged = _graduate(search, closures, options)
        else:
            rule = _rule(closures, options)
            search.approach(rule)
            converged = search.run(rule, options.iterations - search.solves, options.tolerance)
        poses, chi2 = search.state.poses, search.state.chi2
        poses[:, 2] = wrap_angles(poses[:, 2])
        return Solution(poses, chi2, rule.weights(chi2), search.solves, converged)

    def _equations_of(self, graph: PoseGraph) -> NormalEquations:
        first, second, equations = graph.edges.first, graph.edges.second, self._equations
        if equations is None or not equations.has_pattern(graph.node_count, first, second):
            equations = self._equations = NormalEquations(graph.node_count, first, second, self._fixed)
        return equations


def _rule(closures: NDArray[np.bool_], options: SolverOptions) -> WeightRule:
    if options.robust is Robust.SCALING:
        return CovarianceScaling(closures, options.closure_chi2)
    return FixedWeights(np.ones(len(closures)))


def _graduate(search: Minimisation, closures: NDArray[np.bool_], options: SolverOptions) -> tuple[WeightRule, bool]:
    """Run graduated non-convexity, from least squares of all edges to the inliers' alone; then scale covariances."""
    limit = options.closure_chi2
    rule = FixedWeights(np.ones(len(closures)))
    search.approach(rule)
    search.run(rule, _FIRST_SOLVES, options.tolerance)
    worst = float(search.state.chi2[closures].max(initial=0.0))
    control = limit / (2.0 * worst - limit) if worst > limit else np.inf
    while control < _LAST_CONTROL and search.solves < options.iterations:
        rule = FixedWeights(np.where(closures, truncated_weights(search.state.chi2, limit, control), 1.0))
        search.run(rule, 1, options.tolerance)
        control *= _CONTROL_FACTOR
    final = CovarianceScaling(closures, limit)
    return final, search.run(final, max(1, options.iterations - search.solves), options.tolerance)
