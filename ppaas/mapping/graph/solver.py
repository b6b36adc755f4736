"""Solver for pose graphs: the poses that fit the measurements best, with doubtful closures given less weight."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.consistency import largest_consistent_set
from ppaas.mapping.graph.kernels.edges import edge_errors
from ppaas.mapping.graph.normal_equations import NormalEquations
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges, PoseGraph, components
from ppaas.mapping.graph.robust_weights import TRUSTED, CovarianceScaling, FixedWeights, WeightRule, truncated_weights
from ppaas.planar_poses import PoseArray, wrap_angles

# -- Levenberg-Marquardt steps with reweighted edges -------------------------------------------------------------------

_LEAST_DAMPING, _MOST_DAMPING = 1e-6, 1e6
"""Bounds of the share of the diagonal that is added to it; below, none is added, above, no step is tried."""

_ABSOLUTE_DAMPING = 1e-9
"""Added to the diagonal; makes edges without information in some direction solvable."""

_NEAR, _SHRINKING = 0.05, 1.0
"""Step below which the factor of the last solve is kept [m, rad], if the step is at most this part of the one before.

A factorisation takes eight times as long as a solve with its factor.
"""

_FAR = 100.0
"""Mean squared Mahalanobis distance of the edges above which the poses are far from the solution."""


@dataclass
class SolverState:
    """Poses with the errors (m, 3) and squared Mahalanobis distances (m,) of the edges at them."""

    poses: PoseArray
    errors: NDArray[np.float64]
    chi2: NDArray[np.float64]


class Minimisation:
    """Minimises the loss of the edges of a graph from its current state; counts its linear solves.

    Parameters
    ----------
    poses : (n, 3) array
        Start.
    edges : Edges
    equations : NormalEquations
        Equations with the pattern of these edges.
    """

    def __init__(self, poses: PoseArray, edges: Edges, equations: NormalEquations) -> None:
        self._edges, self._equations = edges, equations
        self.state = self.state_at(poses)
        self.solves = 0

    def state_at(self, poses: PoseArray) -> SolverState:
        """Return the state at some poses."""
        state = SolverState(poses, np.empty((len(self._edges.first), 3)), np.empty(len(self._edges.first)))
        edge_errors(poses, *self._edges[:4], state.errors, state.chi2)
        return state

    def approach(self, rule: WeightRule) -> None:
        """Make a first step towards a far solution: directly, or by orientations first, whichever has less loss.

        Orientations alone are nearly a linear problem, and positions are one, given them (Carlone et al., *A fast and
        accurate approximation for planar pose graph optimization*, IJRR 2014).
        """
        state, weights = self.state, rule.weights(self.state.chi2)
        if weights @ state.chi2 <= _FAR * max(1.0, weights.sum()):
            return
        turned = self._turned(state, weights)
        for start in (state, turned):
            reached = self._stepped(start, rule, 0.0)
            if reached is not None and rule.loss(reached.chi2) < rule.loss(self.state.chi2):
                self.state = reached

    def run(self, rule: WeightRule, solves: int, tolerance: float) -> bool:
        """Step until no pose moves by more than the tolerance [m, rad]; return whether that was reached.

        Parameters
        ----------
        rule : WeightRule
        solves : int
            Largest number of linear solves.
        tolerance : float
        """
        damping, moved, keeps = 0.0, np.inf, False
        for _ in range(solves):
            before, reached = moved, self._stepped(self.state, rule, damping, keeps)
            if reached is not None:
                moved = float(np.abs(reached.poses - self.state.poses).max(initial=0.0))
                if moved <= tolerance:
                    self.state = reached
                    return True
            if reached is not None and rule.loss(reached.chi2) <= rule.loss(self.state.chi2):
                self.state = reached
                damping = damping / 10.0 if damping > _LEAST_DAMPING else 0.0
                keeps = damping == 0.0 and moved < _NEAR and moved < _SHRINKING * before
            elif keeps:
                keeps = False
            else:
                damping = max(10.0 * damping, 10.0 * _LEAST_DAMPING)
            if damping > _MOST_DAMPING:
                return False
        return False

    def _stepped(self, state: SolverState, rule: WeightRule, damping: float, keeps: bool = False) -> SolverState | None:
        """Return the state after one linear solve, with the factor of the last one if that is kept."""
        gradients = np.einsum("mij,mj->mi", self._edges.information, state.errors)
        self._equations.linearise(state.poses, self._edges.information, gradients, rule.weights(state.chi2))
        return self._moved(state, damping, keeps)

    def _moved(self, state: SolverState, damping: float, keeps: bool = False) -> SolverState | None:
        self.solves += 1
        changes = self._equations.step_again() if keeps else self._equations.step(_ABSOLUTE_DAMPING, damping)
        return None if changes is None else self.state_at(state.poses + changes)

    def _turned(self, state: SolverState, weights: NDArray[np.float64]) -> SolverState:
        """Return the state with the orientations that fit best, regardless of positions."""
        turns = np.zeros_like(self._edges.information)
        turns[:, 2, 2] = self._edges.information[:, 2, 2]
        self._equations.linearise(state.poses, turns, turns[:, :, 2] * state.errors[:, 2:], weights)
        return self._moved(state, 0.0) or state


# -- the solver --------------------------------------------------------------------------------------------------------

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


# -- graphs of other programs, whose poses may be far from the solution ------------------------------------------------

_SURE = 3.09
"""Quantile of the standard normal distribution, 99.9 %, up to which the errors of all edges count as noise."""

_EXACT = 1e-6
"""Sum up to which the errors of edges without a loop among them, which fit exactly, count as none."""

_MOST_COMPARED = 2000
"""Largest number of closures of which every two are compared."""


class Choice(NamedTuple):
    """A solution, and the method that led to it."""

    solution: Solution
    robust: Robust


def solve_any_start(graph: PoseGraph, fixed: tuple[int, ...] = ()) -> Choice:
    """Return the best solution of a graph, whatever its poses are.

    Least squares, as g2o solves, is the solution if the errors of all edges are noise by their information. Otherwise,
    some closures are false. Three solutions are compared, and the one with the least loss counts: by scaling from the
    poses of the graph, by graduated non-convexity from least squares, and by scaling from least squares of the largest
    set of closures that agree. Far from the solution, scaling alone would take true closures for false ones.

    Parameters
    ----------
    graph : PoseGraph
        It is left unchanged.
    fixed : tuple of int
        Nodes that keep their poses; without any, the first of each connected part does.
    """
    solver, closures = GraphSolver(fixed), graph.edges.kinds == EdgeKind.CLOSURE
    least = solver.solve(graph, SolverOptions(Robust.NONE))
    rule = CovarianceScaling(closures, SolverOptions().closure_chi2)
    trusted = rule.weights(least.chi2).min(initial=1.0) >= TRUSTED
    if not closures.any() or (trusted and least.chi2.sum() <= _largest_noise(graph, fixed)):
        return Choice(least, Robust.NONE)
    choices = [
        Choice(solver.solve(graph, SolverOptions(robust)), robust) for robust in (Robust.SCALING, Robust.GRADUATED)
    ]
    if closures.sum() <= _MOST_COMPARED:
        choices.append(Choice(solver.solve(_agreed(graph, fixed), SolverOptions(Robust.SCALING)), Robust.SCALING))
    return min(choices, key=lambda choice: rule.loss(choice.solution.chi2))


def _agreed(graph: PoseGraph, fixed: tuple[int, ...]) -> PoseGraph:
    """Return the graph with the poses by least squares of its odometry and the largest set of closures that agree."""
    kept = graph.edges.kinds == EdgeKind.ODOMETRY
    closures = np.flatnonzero(~kept)
    kept[closures] = largest_consistent_set(graph, graph.edges.take(closures))
    moved, part = graph.copy(), graph.copy()
    part.keep_edges(kept)
    moved.move_nodes(GraphSolver(fixed).solve(part, SolverOptions(Robust.NONE)).poses)
    return moved


def _largest_noise(graph: PoseGraph, fixed: tuple[int, ...]) -> float:
    """Return a quantile of the sum of squared errors that noise alone leaves (Wilson, Hilferty, PNAS 17(12), 1931)."""
    part = components(graph)
    held = len(fixed) + len(set(part.tolist()) - set(part[list(fixed)].tolist()))
    freedom = 3 * (graph.edge_count - graph.node_count + held)
    if freedom <= 0:
        return _EXACT
    share = 2.0 / (9.0 * freedom)
    return float(freedom * (1.0 - share + _SURE * math.sqrt(share)) ** 3)
