"""Counterweights: second edges beside the odometry's, with which a solved graph is where a refinement left it.

A refinement of the scans leads to other poses than the edges of the odometry. These have to stay as they were measured,
since joint maps know key frames by them. So each gets a counterweight, an edge of the same two nodes and the same
information, that is off by as much to the other side.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.pose_graph import EdgeKind, Edges, PoseGraph
from ppaas.planar_poses import PoseArray, differences, relative


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
