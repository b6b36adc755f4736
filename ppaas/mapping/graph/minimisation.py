"""Minimisation of the loss of a pose graph: Levenberg-Marquardt steps with reweighted edges."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.kernels.edges import edge_errors
from ppaas.mapping.graph.normal_equations import NormalEquations
from ppaas.mapping.graph.pose_graph import Edges
from ppaas.mapping.graph.robust_weights import WeightRule
from ppaas.planar_poses import PoseArray

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
class State:
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

    def state_at(self, poses: PoseArray) -> State:
        """Return the state at some poses."""
        state = State(poses, np.empty((len(self._edges.first), 3)), np.empty(len(self._edges.first)))
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

    def _stepped(self, state: State, rule: WeightRule, damping: float, keeps: bool = False) -> State | None:
        """Return the state after one linear solve, with the factor of the last one if that is kept."""
        gradients = np.einsum("mij,mj->mi", self._edges.information, state.errors)
        self._equations.linearise(state.poses, self._edges.information, gradients, rule.weights(state.chi2))
        return self._moved(state, damping, keeps)

    def _moved(self, state: State, damping: float, keeps: bool = False) -> State | None:
        self.solves += 1
        changes = self._equations.step_again() if keeps else self._equations.step(_ABSOLUTE_DAMPING, damping)
        return None if changes is None else self.state_at(state.poses + changes)

    def _turned(self, state: State, weights: NDArray[np.float64]) -> State:
        """Return the state with the orientations that fit best, regardless of positions."""
        turns = np.zeros_like(self._edges.information)
        turns[:, 2, 2] = self._edges.information[:, 2, 2]
        self._equations.linearise(state.poses, turns, turns[:, :, 2] * state.errors[:, 2:], weights)
        return self._moved(state, 0.0) or state
