"""Solver for graphs of other programs, whose poses may be the solution or far from it, as poses of the odometry are."""

import math
from typing import NamedTuple

import numpy as np

from ppaas.mapping.graph.components import components
from ppaas.mapping.graph.consistency import largest_consistent_set
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.graph.robust_weights import TRUSTED, CovarianceScaling
from ppaas.mapping.graph.solver import GraphSolver, Robust, Solution, SolverOptions

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
