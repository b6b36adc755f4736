"""Pairwise consistency of closures: the sets in which every two agree (Mangelson et al., ICRA 2018)."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.pose_graph import EdgeKind, Edges, PoseGraph
from ppaas.planar_poses import PoseArray, compose, inverse, relative, rotated

# -- largest clique of a graph -----------------------------------------------------------------------------------------

_EXPANSIONS = 20_000
"""Nodes of the search tree to expand before the largest clique found so far is returned."""

_Frame = tuple[list[int], int, list[tuple[int, int]]]


def largest_clique(connected: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the nodes of a largest clique, ascending.

    Branch and bound with greedy colouring (Tomita, Seki, 2003; bit sets as in San Segundo et al., 2011). The search is
    exact up to a number of expansions, and greedy beyond it.

    Parameters
    ----------
    connected : (m, m) bool array
        Symmetric; the diagonal is ignored.
    """
    order = np.argsort(-connected.sum(axis=1), kind="stable")
    matrix = connected[np.ix_(order, order)] & ~np.eye(len(order), dtype=np.bool_)
    found = _CliqueSearch([_bits(row) for row in matrix]).run()
    return np.sort(order[found])


def _bits(mask: NDArray[np.bool_]) -> int:
    """Return a mask as an integer with bit k for entry k."""
    return int.from_bytes(np.packbits(mask, bitorder="little").tobytes(), "little")


class _CliqueSearch:
    """Depth-first search with the neighbours of each node as bit sets."""

    def __init__(self, neighbours: list[int]) -> None:
        self._neighbours = neighbours
        self._best: list[int] = []
        self._left = _EXPANSIONS

    def run(self) -> list[int]:
        """Return a largest clique."""
        # Frames of the depth-first search: clique, candidates, and the order in which to try them.
        everything = (1 << len(self._neighbours)) - 1
        stack: list[_Frame] = [([], everything, self._coloured(everything))] if everything else []
        while stack and self._left > 0:
            clique, candidates, order = stack[-1]
            if not order or len(clique) + order[-1][1] <= len(self._best):
                stack.pop()
                continue
            node, _ = order.pop()
            self._left -= 1
            stack[-1] = (clique, candidates & ~(1 << node), order)
            larger, remaining = [*clique, node], candidates & self._neighbours[node]
            if len(larger) > len(self._best):
                self._best = larger
            if remaining:
                stack.append((larger, remaining, self._coloured(remaining)))
        return self._best

    def _coloured(self, candidates: int) -> list[tuple[int, int]]:
        """Return candidates with their colours, ascending; a clique among the first of them has at most that many."""
        coloured, colour = [], 0
        while candidates:
            colour += 1
            free = candidates
            while free:
                node = (free & -free).bit_length() - 1
                coloured.append((node, colour))
                candidates &= ~(1 << node)
                free &= ~(1 << node) & ~self._neighbours[node]
        return coloured


# -- covariances of relative poses along the trajectory ----------------------------------------------------------------

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

_LEAST_INFORMATION = 1e-6
"""Added to the diagonal of information matrices, so that singular ones have an inverse."""


class OdometryChain:
    """Poses by the odometry edges between consecutive nodes alone, with accumulated covariances.

    Covariances are of small motions after the pose, in its own frame; the adjoint of a pose carries them into another
    frame, in which the covariances of successive edges add (Barfoot, Furgale, *Associating uncertainty with
    three-dimensional poses*, T-RO 30(3), 2014, to first order).

    Parameters
    ----------
    graph : PoseGraph
        If several odometry edges connect two consecutive nodes, the first counts.
    """

    def __init__(self, graph: PoseGraph) -> None:
        edges = graph.edges
        following = (edges.kinds == EdgeKind.ODOMETRY) & (edges.second == edges.first + 1)
        count, links = graph.node_count, edges.take(np.flatnonzero(following)[::-1])
        steps, local = np.zeros((count, 3)), np.zeros((count, 3, 3))
        steps[links.second] = links.measurements
        local[links.second] = end_covariances(links)
        linked = np.zeros(count, np.bool_)
        linked[links.second] = True
        self.parts: Ints = np.cumsum(~linked)
        """Number of the unbroken chain that each node is in, (n,)."""
        self.poses: PoseArray = _accumulated(steps)
        """Poses of the nodes by odometry, (n, 3); each chain starts where the one before it ends."""
        carry = adjoints(self.poses)
        self._sums: Floats = np.cumsum(carry @ local @ np.swapaxes(carry, 1, 2), axis=0)

    def relative(self, first: Ints, second: Ints) -> PoseArray:
        """Return the poses of nodes in the frames of others."""
        return relative(self.poses[first], self.poses[second])

    def covariances(self, first: Ints, second: Ints) -> Floats:
        """Return the covariances (m, 3, 3) of those poses, as small motions in the frames of ``second``."""
        sums = self._sums[np.maximum(first, second)] - self._sums[np.minimum(first, second)]
        carry = adjoints(relative(self.poses[second], np.zeros(3)))
        covariances: Floats = carry @ sums @ np.swapaxes(carry, -1, -2)
        return covariances


def end_covariances(edges: Edges) -> Floats:
    """Return the covariances (m, 3, 3) of measurements, as small motions in the frames of the second nodes."""
    inverses: Floats = np.linalg.inv(edges.information + _LEAST_INFORMATION * np.eye(3)).astype(np.float64)
    return rotated(inverses, -edges.measurements[:, 2])


def adjoints(poses: PoseArray) -> Floats:
    """Return the adjoint matrices (…, 3, 3), which carry small motions from the frames at poses to the common frame."""
    c, s = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    matrices = np.zeros((*poses.shape, 3))
    matrices[..., 0, 0] = matrices[..., 1, 1] = c
    matrices[..., 0, 1], matrices[..., 1, 0] = -s, s
    matrices[..., 0, 2], matrices[..., 1, 2], matrices[..., 2, 2] = poses[..., 1], -poses[..., 0], 1.0
    return matrices


def _accumulated(steps: PoseArray) -> PoseArray:
    """Return the products of the first 1, 2, … steps, by doubling."""
    poses, reach = steps.copy(), 1
    while reach < len(poses):
        poses[reach:] = compose(poses[:-reach].copy(), poses[reach:])
        reach *= 2
    return poses


# -- consistent sets ---------------------------------------------------------------------------------------------------

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
