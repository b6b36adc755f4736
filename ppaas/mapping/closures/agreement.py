"""Agreement of closures: closures of wide windows are trusted in sets only."""

import numpy as np

from ppaas.mapping.closures.closure import Closure
from ppaas.mapping.graph.consistency import largest_consistent_set
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges, PoseGraph
from ppaas.mapping.graph.solver import Robust, SolverOptions

AGREEING = 2
"""Fewest closures of wide windows that have to agree before any of them is trusted."""

LEAST_SHARE = 0.5
"""Part of the edges of a closure that has to be consistent with the other closures."""


WAITING = 40
"""Largest number of closures that wait for others; the oldest are given up."""

CLOSING = SolverOptions(Robust.SCALING, iterations=6)
"""Options of the solve after closures were found; poses are near the solution, since few edges are new."""

GRADUATED = SolverOptions(Robust.GRADUATED, iterations=60)
"""Options of a solve from poses that may be far from the solution; closures that contradict others lose all weight."""


def divide(graph: PoseGraph, found: list[Closure], waiting: list[Closure]) -> tuple[list[Closure], list[Closure]]:
    """Divide closures into trusted ones and ones of wide windows that wait for others to agree with.

    Parameters
    ----------
    graph : PoseGraph
        One node per key frame.
    found : list of Closure
        Closures of a search; ones of narrow windows are trusted.
    waiting : list of Closure
        Closures of earlier searches that wait.

    Returns
    -------
    trusted, rest : list of Closure
    """
    wide = [closure for closure in found if closure.wide]
    waiting = waiting + wide
    agreeing = agreeing_closures(graph, waiting) if wide else []
    trusted = [closure for closure in found if not closure.wide] + agreeing
    return trusted, [closure for closure in waiting if closure not in agreeing]


def agreeing_closures(graph: PoseGraph, closures: list[Closure]) -> list[Closure]:
    """Return the closures that agree with each other; none if they are of one submap.

    Parameters
    ----------
    graph : PoseGraph
        One node per key frame.
    closures : list of Closure
        Closures of wide windows that are not in the graph.
    """
    if len(closures) < AGREEING:
        return []
    edges = Edges(*map(np.concatenate, zip(*(closure.edges for closure in closures), strict=True)))
    chosen = largest_consistent_set(graph, edges)
    ends = np.cumsum([len(closure.edges.first) for closure in closures])
    shares = [part.mean() for part in np.split(chosen, ends[:-1])]
    agreeing = [closure for closure, share in zip(closures, shares, strict=True) if share > LEAST_SHARE]
    return agreeing if len({closure.source for closure in agreeing}) >= AGREEING else []


def add_closure(graph: PoseGraph, closure: Closure) -> None:
    """Append the edges of a closure to a graph."""
    for first, second, measurement, information in zip(*closure.edges[:4], strict=True):
        graph.add_edge(int(first), int(second), measurement, information, EdgeKind.CLOSURE)
