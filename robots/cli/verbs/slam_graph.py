"""Solves pose graphs of files, for ``ppaas slam GRAPH.g2o``."""

import time
from pathlib import Path
from typing import Any

from ppaas.errors import InvalidInput
from ppaas.mapping.graph.g2o import format_g2o, parse_g2o
from ppaas.mapping.graph.pose_graph import EdgeKind
from ppaas.mapping.graph.solver import GraphSolver
from ppaas.mapping.pipeline.graph_mapper import TRUSTED


def solve_file(path: Path) -> tuple[bytes, dict[str, Any]]:
    """Solve the graph of a file.

    Parameters
    ----------
    path : Path
        Text of g2o: ``VERTEX_SE2`` and ``EDGE_SE2`` lines. Edges between consecutive ids are trusted, others are
        loop closures.

    Returns
    -------
    bytes
        The solved graph in the same format.
    dict
        Numbers of ``nodes``, ``edges`` and ``distrusted_edges`` (closures that contradict the others), ``chi2``,
        ``iterations`` and ``seconds``.

    Raises
    ------
    InvalidInput
        The file cannot be read, or is not a graph.
    """
    try:
        with path.open(encoding="ascii") as file:
            graph = parse_g2o(file)
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput(f"cannot read the graph: {error}") from error
    begin = time.perf_counter()
    solution = GraphSolver().solve(graph)
    seconds = time.perf_counter() - begin
    graph.move_nodes(solution.poses)
    distrusted = (graph.edges.kinds == EdgeKind.CLOSURE) & (solution.weights < TRUSTED)
    answer = {
        "nodes": graph.node_count,
        "edges": graph.edge_count,
        "chi2": round(float((solution.weights * solution.chi2).sum()), 3),
        "distrusted_edges": int(distrusted.sum()),
        "iterations": solution.iterations,
        "seconds": round(seconds, 3),
    }
    return "".join(format_g2o(graph)).encode(), answer
