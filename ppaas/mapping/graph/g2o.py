"""Pose graphs as text in the format of g2o (Kümmerle et al., ICRA 2011): VERTEX_SE2, EDGE_SE2, FIX."""

from collections.abc import Iterable, Iterator

from ppaas.mapping.graph.pose_graph import PoseGraph


def parse_g2o(lines: Iterable[str]) -> PoseGraph:
    """Return the graph of the lines of a file; nodes are in order of their ids.

    An edge between consecutive ids is odometry, any other a closure.

    Raises
    ------
    InvalidGraph
        A line is malformed; the text names its number.
    """
    raise NotImplementedError


def format_g2o(graph: PoseGraph) -> Iterator[str]:
    """Yield the lines of a graph, each with its newline; node 0 is fixed."""
    raise NotImplementedError
