"""Division of a mapping into submaps, as when it was made."""

import numpy as np

from ppaas.mapping.closures.submaps import Submaps
from ppaas.mapping.graph.pose_graph import Edges, PoseGraph
from ppaas.mapping.serialization.rows import divided_edges


def divided_submaps(graph: PoseGraph, travel: float) -> tuple[Submaps, Edges]:
    """Return the submaps of a graph, and its edges that are not steps between successive key frames.

    Parameters
    ----------
    graph : PoseGraph
        One node per key frame. A chain that a key frame without a step begins has separate submaps.
    travel : float
        Length after which a submap is finished [m].
    """
    submaps, edges = Submaps(travel), graph.edges
    steps, others = divided_edges(graph)
    for edge in steps.tolist():
        if edge < 0:
            submaps.finish()
        submaps.add(np.zeros(3) if edge < 0 else edges.measurements[edge])
    return submaps, others
