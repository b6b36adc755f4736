"""Solves pose graphs of files, for ``ppaas slam GRAPH.g2o``."""

import time
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import BufferedReader, TextIOWrapper
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from ppaas.errors import InvalidInput
from ppaas.mapping.graph.g2o import GraphFile, parse_g2o
from ppaas.mapping.graph.pose_graph import EdgeKind, components
from ppaas.mapping.graph.robust_weights import TRUSTED
from ppaas.mapping.graph.solver import Choice, GraphSolver, Robust, SolverOptions, solve_any_start
from robots.recordings.files import SUFFIXES, UncompressedFile, has_bag_name

ENDING = ".g2o"
"""Ending of the names of pose graphs."""

TAGS = ("VERTEX", "EDGE", "FIX")
"""Beginnings of the first lines of pose graphs."""

SCANS = ("ROBOTLASER", "FLASER")
"""Beginnings of lines with scans, of which a map is made."""

MOST_COMMENTS = 1000
"""Number of lines among which the first element is."""


@dataclass(frozen=True)
class SolvedGraph:
    """A solved graph.

    Parameters
    ----------
    content : bytes
        It in the format of g2o or TORO, with the ids, the order and, in g2o, the fixed vertices of its file.
    answer : dict
        Numbers of ``nodes``, ``edges``, ``fixed`` vertices and ``distrusted_edges`` (closures that contradict the
        others), ``chi2``, ``method``, ``iterations``, ``seconds``, and ``left_out``: numbers of lines by tag.
    notes : list of str
        What the user should know about the file and the solution.
    """

    content: bytes
    answer: dict[str, Any]
    notes: list[str]


def is_graph(path: Path) -> bool:
    """Return whether a file is a pose graph: by its name, or by lines of vertices and edges and none of scans."""
    bare = path.with_suffix("") if path.suffix[1:].lower() in SUFFIXES else path
    if bare.suffix.lower() == ENDING:
        return True
    if has_bag_name(path) or not path.is_file():
        return False
    with UncompressedFile(path) as file, _text(file) as lines:
        first = next((line.split()[0] for line in islice(lines, MOST_COMMENTS) if line.split("#", 1)[0].split()), "")
        return first.startswith(TAGS) and not any(line.startswith(SCANS) for line in lines)


def solve_file(path: Path, method: str | None = None, *, of_toro: bool = False) -> SolvedGraph:
    """Solve the graph of a file.

    Parameters
    ----------
    path : Path
        Text of g2o or TORO. Edges between successive ids are trusted, others are loop closures.
    method : {"none", "scaling", "graduated"}, optional
        How closures that contradict the others lose weight; by default, what suits the graph.
    of_toro : bool
        Whether the content is in the format of TORO.

    Raises
    ------
    InvalidInput
        The file cannot be read, or is not a graph.
    """
    file = _read(path)
    begin = time.perf_counter()
    found = _solve(file, method)
    seconds = time.perf_counter() - begin
    solution, graph = found.solution, file.graph
    graph.move_nodes(solution.poses)
    closures = graph.edges.kinds == EdgeKind.CLOSURE
    distrusted = int((closures & (solution.weights < TRUSTED)).sum())
    answer = {
        "nodes": graph.node_count,
        "edges": graph.edge_count,
        "fixed": len(file.fixed),
        "chi2": round(float((solution.weights * solution.chi2).sum()), 3),
        "distrusted_edges": distrusted,
        "method": found.robust.value,
        "iterations": solution.iterations,
        "seconds": round(seconds, 3),
        "left_out": {tag: lines.count for tag, lines in file.left_out.items()},
    }
    notes = _notes(file) + _doubts(distrusted, int(closures.sum()))
    if of_toro and file.fixed:
        notes.append(f"{len(file.fixed)} fixed vertices are not written as fixed: TORO has no such line")
    return SolvedGraph("".join(file.lines(of_toro=of_toro)).encode(), answer, notes)


def _read(path: Path) -> GraphFile:
    with UncompressedFile(path) as file, _text(file) as lines:
        found = parse_g2o(lines)
        if file.cut:
            raise InvalidInput(
                f"cannot read {path}: its compressed content ends early, and a part of a graph is another one"
            )
        return found


@contextmanager
def _text(file: UncompressedFile) -> Iterator[TextIOWrapper]:
    """Read a file as text in UTF-8, or in UTF-16 with a byte-order mark."""
    with BufferedReader(file) as stream:
        encoding = "utf-16" if stream.peek(2)[:2] in (BOM_UTF16_LE, BOM_UTF16_BE) else "utf-8-sig"
        with TextIOWrapper(stream, encoding=encoding, errors="replace") as lines:
            yield lines


def _solve(file: GraphFile, method: str | None) -> Choice:
    if method is None:
        return solve_any_start(file.graph, file.fixed)
    options = SolverOptions(Robust(method))
    return Choice(GraphSolver(file.fixed).solve(file.graph, options), options.robust)


def _notes(file: GraphFile) -> list[str]:
    """Return what of the file is not, or only in part, in the solution."""
    notes = [
        f"{lines.count} {'line' if lines.count == 1 else 'lines'} {tag} left out, the first is line {lines.line}: "
        "only poses in the plane and edges between them are solved"
        for tag, lines in file.left_out.items()
    ]
    notes += [
        f"line {line}: FIX names vertex {vertex}, which no VERTEX_SE2 defines"
        for vertex, line in file.unknown_fixed.items()
    ]
    parts = components(file.graph)
    count, held = int(parts.max()) + 1, len(np.unique(parts[list(file.fixed)]))
    if count > max(1, held):
        stays = "of each without FIX, the vertex of the least id stays"
        notes.append(f"the graph has {count} parts that no edge connects; {stays}")
    return notes


def _doubts(distrusted: int, closures: int) -> list[str]:
    if 2 * distrusted <= closures:
        return []
    return [
        f"{distrusted} of {closures} loop closures contradict the other edges and have little weight: either most are "
        "false, or the information of the edges is too large; --robust none trusts all of them"
    ]
