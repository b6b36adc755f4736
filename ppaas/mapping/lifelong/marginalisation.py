"""Marginalisation: nodes leave a pose graph, and edges that led through them are joined.

A node with two edges is removed exactly, to first order. The edges of a node with more are joined with the most certain
one of the odometry. That is the tree of Chow and Liu for the neighbours of the node, as in H. Kretzschmar and C.
Stachniss, *Information-theoretic compression of pose graphs for laser-based SLAM* (IJRR 2012): the errors of other
pairs are overestimated, and the graph stays sparse.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.pose_graph import EdgeKind, Edges, PoseGraph, join_edges
from ppaas.planar_poses import PoseArray, compose, inverse

MOST_CLOSURES = 8
"""Largest number of closures that a node keeps when edges are joined; less certain ones are left out."""

LEAST_INFORMATION = 1e-6
"""Least eigenvalue of an information matrix, as a part of its largest one: a smaller one is rounded to float32."""

Key = tuple[int, int, EdgeKind]


class UncertainStep(NamedTuple):
    """Measured pose of a node in the frame of another.

    Parameters
    ----------
    measurement : (3,) array
        x, y [m], theta [rad].
    covariance : (3, 3) array
        In the frame of the other node.
    """

    measurement: PoseArray
    covariance: NDArray[np.float64]

    @property
    def information(self) -> NDArray[np.float64]:
        """Inverse of the covariance, symmetric."""
        found = np.asarray(np.linalg.inv(self.covariance), np.float64)
        return 0.5 * (found + found.T)

    @property
    def spread(self) -> float:
        """Sum of the variances of the position [m²]."""
        return float(self.covariance[0, 0] + self.covariance[1, 1])

    def inverted(self) -> "UncertainStep":
        """Return the step back."""
        x, y, theta = self.measurement
        c, s = np.cos(theta), np.sin(theta)
        jacobian = np.array([(-c, -s, s * x - c * y), (s, -c, c * x + s * y), (0.0, 0.0, -1.0)])
        return UncertainStep(inverse(self.measurement), jacobian @ self.covariance @ jacobian.T)

    def then(self, other: "UncertainStep") -> "UncertainStep":
        """Return this step followed by another one, whose error does not depend on that of this one."""
        theta, (x, y, _) = self.measurement[2], other.measurement
        c, s = np.cos(theta), np.sin(theta)
        of_this = np.array([(1.0, 0.0, -s * x - c * y), (0.0, 1.0, c * x - s * y), (0.0, 0.0, 1.0)])
        of_other = np.array([(c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)])
        covariance = of_this @ self.covariance @ of_this.T + of_other @ other.covariance @ of_other.T
        return UncertainStep(compose(self.measurement, other.measurement), covariance)


def without_nodes(graph: PoseGraph, removed: NDArray[np.bool_]) -> PoseGraph:
    """Return a graph of the other nodes, in their order.

    Parameters
    ----------
    graph : PoseGraph
        Unchanged.
    removed : (n,) bool array
        Nodes that leave it.
    """
    edges = graph.edges
    touched = removed[edges.first] | removed[edges.second]
    around = np.zeros(graph.node_count, np.bool_)
    around[edges.first[touched]] = around[edges.second[touched]] = True
    inside = around[edges.first] & around[edges.second]  # edges that a joined one may be parallel to
    joining = _Joining(edges.take(inside))
    for node in np.flatnonzero(removed).tolist():
        joining.remove(node)
    kept = edges.take(~inside)
    number = np.cumsum(~removed) - 1
    all_edges = join_edges(kept, joining.joined(kept))
    renumbered = all_edges._replace(first=number[all_edges.first], second=number[all_edges.second])
    return PoseGraph.of(graph.poses[~removed], renumbered)


class _Joining:
    """Edges of nodes that are removed; between two nodes at most one of each kind, the most certain one."""

    def __init__(self, edges: Edges) -> None:
        self._steps: dict[Key, UncertainStep] = {}
        self._at: dict[int, set[Key]] = {}
        covariances = _covariances(edges.information)
        for first, second, measurement, covariance, kind in zip(*edges[:3], covariances, edges.kinds, strict=True):
            self._add(int(first), int(second), EdgeKind(kind), UncertainStep(measurement, covariance))

    def remove(self, node: int) -> None:
        """Remove a node, and join its edges."""
        keys = sorted(self._at.pop(node, ()))
        if not keys:
            return
        spine = min(keys, key=lambda key: (key[2] != EdgeKind.ODOMETRY, self._steps[key].spread))
        to, approach = _other(spine, node), self._from(node, spine).inverted()
        onward = [(_other(key, node), key[2], self._from(node, key)) for key in keys]
        for key in keys:
            del self._steps[key]
            self._at[_other(key, node)].discard(key)
        for end, kind, step in onward:
            if end != to:
                self._add(to, end, kind, approach.then(step))

    def joined(self, beside: Edges) -> Edges:
        """Return the edges that are left, without closures that nodes have too many of.

        Parameters
        ----------
        beside : Edges
            Other edges of the graph.
        """
        keys = list(self._sparse(beside))
        steps = [self._steps[key] for key in keys]
        ends = np.array(keys, np.int64).reshape(-1, 3)
        return Edges(
            ends[:, 0], ends[:, 1],
            np.array([step.measurement for step in steps]).reshape(-1, 3),
            np.array([step.information for step in steps]).reshape(-1, 3, 3),
            ends[:, 2].astype(np.uint8),
        )  # fmt: skip

    def _sparse(self, beside: Edges) -> Iterator[Key]:
        """Yield the edges of the odometry, then closures, the most certain first, of which each node has few."""
        closures = beside.kinds == EdgeKind.CLOSURE
        ends = np.concatenate((beside.first[closures], beside.second[closures]))
        counts = dict(zip(*(found.tolist() for found in np.unique(ends, return_counts=True)), strict=True))
        chains = _Chains(beside)
        for key in sorted(self._steps, key=lambda key: (key[2] == EdgeKind.CLOSURE, self._steps[key].spread)):
            first, second, kind = key
            full = any(counts.get(end, 0) >= MOST_CLOSURES for end in (first, second))
            if not chains.join(first, second) and kind == EdgeKind.CLOSURE and full:
                continue
            if kind == EdgeKind.CLOSURE:
                counts[first], counts[second] = counts.get(first, 0) + 1, counts.get(second, 0) + 1
            yield key

    def _add(self, first: int, second: int, kind: EdgeKind, step: UncertainStep) -> None:
        if first > second:
            first, second, step = second, first, step.inverted()
        key = first, second, kind
        known = self._steps.get(key)
        if known is None or step.spread < known.spread:
            self._steps[key] = step
        for node in (first, second):
            self._at.setdefault(node, set()).add(key)

    def _from(self, node: int, key: Key) -> UncertainStep:
        step = self._steps[key]
        return step if key[0] == node else step.inverted()


class _Chains:
    """Parts of a graph that edges connect."""

    def __init__(self, edges: Edges) -> None:
        self._roots: dict[int, int] = {}
        for first, second in zip(edges.first.tolist(), edges.second.tolist(), strict=True):
            self.join(first, second)

    def join(self, first: int, second: int) -> bool:
        """Connect two nodes; return whether they were apart."""
        one, two = self._root(first), self._root(second)
        self._roots[two] = one
        return one != two

    def _root(self, node: int) -> int:
        root = node
        while self._roots.setdefault(root, root) != root:
            root = self._roots[root]
        while self._roots[node] != root:
            self._roots[node], node = root, self._roots[node]
        return root


def _covariances(information: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the covariances of information matrices (m, 3, 3), large where they determine nothing."""
    values, axes = np.linalg.eigh(information)
    least = LEAST_INFORMATION * np.maximum(values[:, -1:], LEAST_INFORMATION)
    covariances: NDArray[np.float64] = (axes / np.maximum(values, least)[:, np.newaxis]) @ axes.transpose(0, 2, 1)
    return covariances


def _other(key: Key, node: int) -> int:
    return key[1] if key[0] == node else key[0]
