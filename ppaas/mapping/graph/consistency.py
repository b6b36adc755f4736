"""Pairwise consistency of closures: the sets in which every two agree (Mangelson et al., ICRA 2018)."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.largest_clique import largest_clique
from ppaas.mapping.graph.odometry_chain import OdometryChain, adjoints, end_covariances
from ppaas.mapping.graph.pose_graph import Edges, PoseGraph
from ppaas.planar_poses import compose, inverse

CHI2 = 11.34
"""99 % quantile of the squared Mahalanobis distance with three degrees of freedom."""


def largest_consistent_set(graph: PoseGraph, closures: Edges, chi2: float = CHI2) -> NDArray[np.bool_]:
    """Return a mask (m,) of the closures in the largest set of closures that agree pairwise.

    Two closures agree if the loop along both and the odometry between their ends closes within the covariances.

    Parameters
    ----------
    graph : PoseGraph
        Its odometry edges connect the nodes; its poses and closures are ignored.
    closures : Edges
        Candidates between nodes of the graph.
    chi2 : float
        Largest squared Mahalanobis distance of a loop.
    """
    return next(consistent_sets(graph, closures, chi2), np.zeros(len(closures.first), np.bool_))


def consistent_sets(graph: PoseGraph, closures: Edges, chi2: float = CHI2) -> Iterator[NDArray[np.bool_]]:
    """Yield masks (m,) of disjoint consistent sets: the largest, the largest of the other closures, and so on.

    A second set that is nearly as large as the first marks an ambiguous place. Parameters are the same as for
    `largest_consistent_set`.
    """
    agree = loop_chi2(graph, closures) <= chi2
    remaining = np.arange(len(closures.first))
    while remaining.size:
        chosen = remaining[largest_clique(agree[np.ix_(remaining, remaining)])]
        yield np.isin(np.arange(len(agree)), chosen)
        remaining = np.setdiff1d(remaining, chosen)


def loop_chi2(graph: PoseGraph, closures: Edges) -> NDArray[np.float64]:
    """Return the squared Mahalanobis distances (m, m) by which the loops along two closures each miss their start.

    It is 0 for loops that odometry does not connect. Parameters are the same as for `largest_consistent_set`.
    """
    chain, count = OdometryChain(graph), len(closures.first)
    local = end_covariances(closures)
    distances = np.zeros((count, count))
    for k in range(count - 1):
        distances[k, k + 1 :] = _loops(chain, closures, local, k)
    return distances + distances.T


def _loops(chain: OdometryChain, closures: Edges, local: NDArray[np.float64], k: int) -> NDArray[np.float64]:
    """Return the squared Mahalanobis distances of the loops of closure k with each later one.

    The loop: along closure k, along odometry to the end of the other, back along the other, along odometry to the
    start of k. The covariances of these four are carried into the frame of the start, where they add.
    """
    a, b, out = closures.first[k], closures.second[k], closures.measurements[k]
    c, d, back = closures.first[k + 1 :], closures.second[k + 1 :], closures.measurements[k + 1 :]
    far, near = compose(out, chain.relative(b, d)), chain.relative(c, a)
    missed = compose(compose(far, inverse(back)), near)
    carry, start = adjoints(far), adjoints(out)
    total = start @ local[k] @ start.T + chain.covariances(c, a)
    total = total + carry @ (chain.covariances(b, d) + local[k + 1 :]) @ np.swapaxes(carry, 1, 2)
    distances = np.einsum("mi,mi->m", missed, np.linalg.solve(total, missed[:, :, None])[:, :, 0])
    connected = (chain.parts[b] == chain.parts[d]) & (chain.parts[c] == chain.parts[a])
    result: NDArray[np.float64] = np.where(connected, distances, 0.0)
    return result
