"""Pose graph: poses of key frames, and measured relative poses between them.

A refinement of the scans leads to other poses than the edges of the odometry. These have to stay as they were measured,
since joint maps know key frames by them. So each gets a *counterweight*, a second edge of the same two nodes and the
same information, that is off by as much to the other side: the solved graph is where the refinement left it.
"""

from collections.abc import Callable
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.errors import InvalidGraph
from ppaas.planar_poses import PoseArray, differences, relative


class EdgeKind(IntEnum):
    """Origin of an edge; the solver trusts odometry, and may reduce the weight of a closure."""

    ODOMETRY = 0
    CLOSURE = 1


class Edges(NamedTuple):
    """Edges as arrays, one entry an edge.

    Attributes
    ----------
    first, second : (m,) int64 array
        Nodes at the two ends.
    measurements : (m, 3) float64 array
        Pose of the second node in the frame of the first: x, y [m], theta [rad].
    information : (m, 3, 3) float64 array
        Inverse covariances of the measurements, in the frame of the first node.
    kinds : (m,) uint8 array
        `EdgeKind` of each edge.
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    measurements: PoseArray
    information: NDArray[np.float64]
    kinds: NDArray[np.uint8]

    def take(self, which: NDArray[np.bool_] | NDArray[np.int64]) -> "Edges":
        """Return copies of some edges, by a mask or by indices."""
        return _of_each(self, lambda array: array[which])

    def since(self, first: int) -> "Edges":
        """Return the edges from an index on."""
        return _of_each(self, lambda array: array[first:])


def join_edges(*parts: Edges) -> Edges:
    """Return copies of sets of edges as one."""
    return Edges(*map(np.concatenate, zip(*parts, strict=True)))


_NO_EDGES = Edges(
    np.empty(0, np.int64), np.empty(0, np.int64), np.empty((0, 3)), np.empty((0, 3, 3)), np.empty(0, np.uint8)
)


class PoseGraph:
    """Nodes and edges; both grow at the end in amortised constant time. Node 0 fixes the frame."""

    def __init__(self) -> None:
        self._poses: PoseArray = np.empty((0, 3))
        self._edges = _NO_EDGES
        self._node_count = self._edge_count = 0

    @property
    def node_count(self) -> int:
        """Number of nodes."""
        return self._node_count

    @property
    def edge_count(self) -> int:
        """Number of edges."""
        return self._edge_count

    @property
    def poses(self) -> PoseArray:
        """Poses of the nodes, (n, 3): a read-only view that the next change of the graph may invalidate."""
        return _read_only(self._poses[: self._node_count])

    @property
    def edges(self) -> Edges:
        """All edges: read-only views that the next change of the graph may invalidate."""
        return _of_each(self._edges, lambda array: _read_only(array[: self._edge_count]))

    def add_node(self, pose: ArrayLike) -> int:
        """Append a node and return its index.

        Parameters
        ----------
        pose : (3,) array or Pose2D
            x, y [m], theta [rad].

        Raises
        ------
        InvalidGraph
            The pose is not finite.
        """
        row = np.asarray(pose, np.float64)
        if row.shape != (3,) or not np.isfinite(row).all():
            raise InvalidGraph(f"pose of a node must be three finite numbers, got {pose!r}")
        self._poses = _with_space(self._poses, self._node_count)
        self._poses[self._node_count] = row
        self._node_count += 1
        return self._node_count - 1

    def add_edge(self, first: int, second: int, measurement: ArrayLike, information: ArrayLike, kind: EdgeKind) -> int:
        """Append an edge and return its index.

        Parameters
        ----------
        first, second : int
            Nodes at its ends.
        measurement : (3,) array or Pose2D
            Pose of the second node in the frame of the first: x, y [m], theta [rad].
        information : (3, 3) array
            Inverse covariance of the measurement, in the frame of the first node.
        kind : EdgeKind

        Raises
        ------
        InvalidGraph
            A node does not exist, the ends are the same, or a number is not finite.
        """
        measured, weights = np.asarray(measurement, np.float64), np.asarray(information, np.float64)
        self._check_ends(first, second)
        if measured.shape != (3,) or weights.shape != (3, 3):
            raise InvalidGraph("an edge needs a measurement of shape (3,) and an information of shape (3, 3)")
        if not (np.isfinite(measured).all() and np.isfinite(weights).all()):
            raise InvalidGraph(f"edge from node {first} to node {second} has a number that is not finite")
        self._edges = _of_each(self._edges, lambda array: _with_space(array, self._edge_count))
        edge, edges = self._edge_count, self._edges
        edges.first[edge], edges.second[edge], edges.kinds[edge] = first, second, kind
        edges.measurements[edge], edges.information[edge] = measured, weights
        self._edge_count += 1
        return edge

    def add_edges(self, edges: Edges) -> None:
        """Append edges; raises as `add_edge`."""
        joined = PoseGraph.of(self.poses, join_edges(self.edges, edges))
        self._edges, self._edge_count = joined._edges, joined._edge_count

    def move_nodes(self, poses: PoseArray) -> None:
        """Replace the poses of all nodes by an (n, 3) array."""
        self._poses[: self._node_count] = poses

    @classmethod
    def of(cls, poses: PoseArray, edges: Edges) -> "PoseGraph":
        """Return a graph with copies of these nodes and edges.

        Raises
        ------
        InvalidGraph
            A node does not exist, the ends of an edge are the same, or a number is not finite.
        """
        graph, ends = cls(), np.concatenate((edges.first, edges.second))
        if not all(np.isfinite(numbers).all() for numbers in (poses, edges.measurements, edges.information)):
            raise InvalidGraph("the graph has a pose or an edge with a number that is not finite")
        if len(ends) and not 0 <= ends.min() <= ends.max() < len(poses):
            raise InvalidGraph(f"an edge names node {ends.max()}; the graph has {len(poses)} nodes")
        if np.any(edges.first == edges.second):
            raise InvalidGraph("the graph has an edge from a node to itself")
        graph._poses, graph._node_count = poses.copy(), len(poses)
        graph._edges, graph._edge_count = _of_each(edges, np.copy), len(edges.first)
        return graph

    def copy(self) -> "PoseGraph":
        """Return a graph with the same nodes and edges, which changes apart from this one."""
        copied = PoseGraph()
        copied._poses, copied._node_count = self.poses.copy(), self._node_count
        copied._edges, copied._edge_count = _of_each(self.edges, np.copy), self._edge_count
        return copied

    def renew_measurements(self, which: NDArray[np.int64], measurements: PoseArray) -> None:
        """Replace the measurements of some edges, by their indices (m,), by an (m, 3) array."""
        self._edges.measurements[which] = measurements

    def keep_edges(self, keep: NDArray[np.bool_]) -> None:
        """Remove the edges whose entry of an (m,) mask is false."""
        self._edges = self.edges.take(keep)
        self._edge_count = len(self._edges.first)

    def _check_ends(self, first: int, second: int) -> None:
        for node in (first, second):
            if not 0 <= node < self._node_count:
                raise InvalidGraph(f"edge names node {node}; the graph has {self._node_count} nodes")
        if first == second:
            raise InvalidGraph(f"edge from node {first} to itself")


def _of_each(edges: Edges, change: Callable[[NDArray[Any]], NDArray[Any]]) -> Edges:
    return Edges(*[change(array) for array in edges])


def _with_space(array: NDArray[Any], count: int) -> NDArray[Any]:
    """Return the array, copied to one of twice the length if its first ``count`` rows fill it."""
    if count < len(array):
        return array
    larger = np.empty((max(64, 2 * count), *array.shape[1:]), array.dtype)
    larger[:count] = array
    return larger


def _read_only(array: NDArray[Any]) -> NDArray[Any]:
    view = array.view()
    view.flags.writeable = False
    return view


# -- components --------------------------------------------------------------------------------------------------------


def components(graph: PoseGraph) -> NDArray[np.int64]:
    """Return the component (n,) of each node, numbered from 0 in the order of their first nodes.

    Most edges join successive nodes: they make chains, and only the edges between chains are visited one by one.
    """
    edges = graph.edges
    low, high = np.minimum(edges.first, edges.second), np.maximum(edges.first, edges.second)
    starts = np.ones(graph.node_count, bool)
    starts[high[high - low == 1]] = False
    chains = np.cumsum(starts) - 1
    roots = list(range(int(starts.sum())))
    for ends in np.unique(np.column_stack((chains[low], chains[high])), axis=0).tolist():
        first, second = sorted(_root(roots, chain) for chain in ends)
        roots[second] = first
    of_chains = np.array([_root(roots, chain) for chain in range(len(roots))], np.int64)
    numbers: NDArray[np.int64] = np.unique(of_chains, return_inverse=True)[1].astype(np.int64)[chains]
    return numbers


def _root(roots: list[int], chain: int) -> int:
    while roots[chain] != chain:
        roots[chain] = chain = roots[roots[chain]]
    return chain


# -- counterweights ----------------------------------------------------------------------------------------------------


def measured_odometry(edges: Edges) -> Edges:
    """Return copies of the edges of the odometry without counterweights."""
    own, _, _ = _odometry(edges)
    return edges.take(np.sort(own))


def balance(graph: PoseGraph, poses: PoseArray) -> None:
    """Add counterweights to a graph, or renew them, so that its odometry pulls no node away from poses (n, 3)."""
    edges = graph.edges
    own, counterweights, of = _odometry(edges)
    refined = relative(poses[edges.first[own]], poses[edges.second[own]])
    opposite = differences(refined, -differences(refined, edges.measurements[own]))
    lacking = np.ones(len(own), np.bool_)
    lacking[of] = False
    added = edges.take(own[lacking])._replace(measurements=opposite[lacking])
    graph.renew_measurements(counterweights, opposite[of])
    graph.add_edges(added)


def _odometry(edges: Edges) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Return the indices of measured edges (m,), of counterweights (c,), and of the edges that these belong to (c,).

    Of several edges between two nodes, the first one was measured.
    """
    odometry = np.flatnonzero(edges.kinds == EdgeKind.ODOMETRY)
    most = int(edges.second.max(initial=0)) + 1
    keys = edges.first[odometry] * most + edges.second[odometry]
    found, at = np.unique(keys, return_index=True)
    later = np.ones(len(odometry), np.bool_)
    later[at] = False
    return odometry[at], odometry[later], np.searchsorted(found, keys[later])
