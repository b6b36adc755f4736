"""Pose graphs as text in the formats of g2o (Kümmerle et al., ICRA 2011) and TORO (Grisetti et al., 2007).

g2o measures errors in the frame of the measured pose, so that the information of a file is in the frame of an edge's
second node; in `PoseGraph` it is in the frame of the first.
"""

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidGraph
from ppaas.geometry import wrap_angle
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.planar_poses import rotated, symmetric, upper_triangle, wrap_angles

# -- elements of g2o and of TORO (Grisetti et al., 2007); one that is not in the plane is left out ---------------------

Number = TypeVar("Number", int, float)

VERTEX, EDGE, FIX = "VERTEX_SE2", "EDGE_SE2", "FIX"

_TORO = {"VERTEX2": VERTEX, "EDGE2": EDGE, "VERTEX": VERTEX, "EDGE": EDGE}
"""Tags of TORO, the latest and the first, and g2o's tags for the same elements."""

_TAGS = {VERTEX: "VERTEX2", EDGE: "EDGE2"}
"""Tags of g2o, and those that TORO writes."""

_OF_TORO = (0, 1, 2, 3, 4, 7, 5, 8, 6)
"""Numbers of an edge of TORO in the order of g2o."""

_TO_TORO = (0, 1, 2, 3, 4, 6, 8, 5, 7)
"""Numbers of an edge of g2o in the order of TORO."""

TORO_ORDER = "xx xy yy θθ xθ yθ"
"""Order of the information of an edge of TORO; g2o's is xx xy xθ yy yθ θθ."""

_NUMBERS = {VERTEX: (1, 3), EDGE: (2, 9)}
"""Ids and numbers after each tag."""

_WITHOUT_EFFECT = ("ROBOTLASER", "RAWLASER", "PARAMS_")
"""Beginnings of the tags of lines that do not change the poses: scans, and parameters of edges that are left out."""

_IN_SPACE = ("VERTEX_SE3", "EDGE_SE3", "VERTEX3", "EDGE3", "VERTEX_SIM3", "EDGE_SIM3")
"""Beginnings of the tags of poses in space."""


@dataclass
class OmittedLines:
    """Lines with a tag that were left out.

    Parameters
    ----------
    line : int
        Number of the first of them.
    count : int
    """

    line: int
    count: int = 0


@dataclass
class Elements:
    """Elements of a file.

    Parameters
    ----------
    vertices : dict of int to tuple
        x, y [m], theta [rad] by the id of the vertex, in the order of the file.
    edges : list
        Number of the line, ids of both ends, and measurement with the upper triangle of its information.
    fixed : dict of int to int
        Ids of fixed vertices, and the numbers of their lines.
    left_out : dict of str to OmittedLines
        Lines that were left out, by tag.
    of_toro : set of int
        Numbers of the lines of edges of TORO.
    """

    vertices: dict[int, tuple[float, ...]] = field(default_factory=dict)
    edges: list[tuple[int, tuple[int, ...], tuple[float, ...]]] = field(default_factory=list)
    fixed: dict[int, int] = field(default_factory=dict)
    left_out: dict[str, OmittedLines] = field(default_factory=dict)
    of_toro: set[int] = field(default_factory=set)


def read_elements(lines: Iterable[str]) -> Elements:
    """Read the elements of the lines of a file, which may come in any order.

    Raises
    ------
    InvalidGraph
        A line is malformed, repeats a vertex with another pose, or is of a graph in space. The text names the number of
        the line.
    """
    elements = Elements()
    for number, line in enumerate(lines, 1):
        words = line.split("#", 1)[0].split()
        if words and not words[0].startswith(_WITHOUT_EFFECT):
            _read(elements, number, words)
    return elements


def _read(elements: Elements, number: int, words: list[str]) -> None:
    tag = _TORO.get(words[0], words[0])
    if tag == FIX:
        for vertex in _numbers(int, words[1:], number, FIX):
            elements.fixed.setdefault(vertex, number)
    elif tag in _NUMBERS:
        _add(elements, number, words)
    elif tag.startswith(_IN_SPACE):
        raise InvalidGraph(
            f"line {number}: {tag[:40]} is an element of a graph in space; graphs are solved in the plane, of "
            f"{VERTEX} and {EDGE}"
        )
    else:
        elements.left_out.setdefault(tag[:40], OmittedLines(number)).count += 1


def _add(elements: Elements, number: int, words: list[str]) -> None:
    tag, (id_count, number_count) = words[0], _NUMBERS[_TORO.get(words[0], words[0])]
    if len(words) != 1 + id_count + number_count:
        raise InvalidGraph(f"line {number}: {tag} takes {id_count + number_count} values, got {len(words) - 1}")
    ids = _numbers(int, words[1 : 1 + id_count], number, tag)
    numbers = _numbers(float, words[1 + id_count :], number, tag)
    if not all(map(math.isfinite, numbers)):
        raise InvalidGraph(f"line {number}: {tag} has a number that is not finite")
    if id_count > 1:
        if tag in _TORO:
            numbers = tuple(numbers[place] for place in _OF_TORO)
            elements.of_toro.add(number)
        elements.edges.append((number, ids, numbers))
    elif elements.vertices.setdefault(ids[0], numbers) != numbers:
        raise InvalidGraph(f"line {number}: vertex {ids[0]} is defined twice, with different poses")


def _numbers(kind: type[Number], words: list[str], line: int, tag: str) -> tuple[Number, ...]:
    try:
        return tuple(map(kind, words))
    except ValueError as error:
        what = "integer ids" if tag == FIX else "integer ids, then numbers"
        raise InvalidGraph(f"line {line}: {tag} takes {what}") from error


# -- files -------------------------------------------------------------------------------------------------------------

ROUNDED = 1e-5
"""Share of its largest number by which an information matrix may be short of positive semidefinite: many programs write
six digits, by which the matrix of a long corridor is."""

_TAG = re.compile(r"[A-Za-z][A-Za-z0-9_:]{2,}")
"""An element of a format of graphs, and not any text or binary content."""

_INDEX_BITS = 48
"""Bits of the number in the keys of gtsam; those above are a letter, and a label, of another robot or another chain."""


@dataclass(frozen=True)
class GraphFile:
    """Content of a file.

    Parameters
    ----------
    graph : PoseGraph
        Nodes are in the order of their ids.
    ids : tuple of int
        Id of each node.
    order : tuple of int
        Nodes in the order of the file.
    fixed : tuple of int
        Nodes that the file fixes, in its order.
    unknown_fixed : dict of int to int
        Ids in lines FIX that no vertex has, with the number of the line.
    left_out : dict of str to OmittedLines
        Lines that are not part of the graph, such as landmarks, by tag.
    edges : sequence of sequence of float
        Measurement and information of each edge, as the file has them, in the order of g2o.
    """

    graph: PoseGraph
    ids: tuple[int, ...]
    order: tuple[int, ...]
    fixed: tuple[int, ...]
    unknown_fixed: dict[int, int]
    left_out: dict[str, OmittedLines]
    edges: Sequence[Sequence[float]]

    def lines(self, *, of_toro: bool = False) -> Iterator[str]:
        """Yield the lines of the graph with the ids, the order, the edges and the fixed vertices of the file.

        TORO has no fixed vertices.
        """
        return _lines(self.graph, self.ids, self.order, () if of_toro else self.fixed, self.edges, of_toro=of_toro)


def parse_g2o(lines: Iterable[str]) -> GraphFile:
    """Return the graph of the lines of a file of g2o or TORO.

    An edge between an id and the next higher one of the file is odometry, any other a closure; so is one between keys
    of gtsam with different letters. Lines of scans (ROBOTLASER1) and of parameters have no effect.

    Raises
    ------
    InvalidGraph
        A line is malformed, repeats a vertex, names an unknown one, is of a graph in space, or has an information
        matrix that is not positive semidefinite; or there is no vertex. The text names the number of the line.
    """
    elements = read_elements(lines)
    if not elements.vertices:
        raise InvalidGraph(_without_vertices(elements))
    ids = tuple(sorted(elements.vertices))
    nodes = {vertex: node for node, vertex in enumerate(ids)}
    return GraphFile(
        _graph_of(elements, nodes),
        ids,
        order=tuple(map(nodes.__getitem__, elements.vertices)),
        fixed=tuple(nodes[vertex] for vertex in elements.fixed if vertex in nodes),
        unknown_fixed={vertex: line for vertex, line in elements.fixed.items() if vertex not in nodes},
        left_out=elements.left_out,
        edges=[numbers for _, _, numbers in elements.edges],
    )


def _without_vertices(elements: Elements) -> str:
    """Return what a file without vertices has instead, and what it needs."""
    tags = [tag for tag in elements.left_out if _TAG.fullmatch(tag)][:5]
    edges = [f"{len(elements.edges)} edges"] if elements.edges else []
    found = ", ".join(edges + tags)
    has = f" It has {found}: give the start poses of its nodes in lines {VERTEX}." if found else ""
    return f"the graph has no {VERTEX}.{has}"


def format_graph(graph: PoseGraph, *, of_toro: bool = False) -> Iterator[str]:
    """Yield the lines of a graph of g2o or TORO, each with its newline; in g2o node 0 is fixed."""
    nodes, edges = range(graph.node_count), graph.edges
    information = upper_triangle(rotated(edges.information, -edges.measurements[:, 2]))
    numbers = np.concatenate((edges.measurements, information), axis=1).tolist()
    return _lines(graph, nodes, nodes, () if of_toro else nodes[:1], numbers, of_toro=of_toro)


def _lines(
    graph: PoseGraph,
    ids: Sequence[int],
    order: Sequence[int],
    fixed: Sequence[int],
    numbers: Sequence[Sequence[float]],
    *,
    of_toro: bool,
) -> Iterator[str]:
    poses, edges = graph.poses.tolist(), graph.edges
    vertex, edge = (_TAGS[VERTEX], _TAGS[EDGE]) if of_toro else (VERTEX, EDGE)
    for node in order:
        yield f"{vertex} {ids[node]} {_joined(poses[node])}\n"
    for first, second, row in zip(edges.first.tolist(), edges.second.tolist(), numbers, strict=True):
        ordered = [row[place] for place in _TO_TORO] if of_toro else row
        yield f"{edge} {ids[first]} {ids[second]} {_joined(ordered)}\n"
    # The order has no meaning, but gtsam 4.3 reads no edge after such a line.
    for node in fixed:
        yield f"{FIX} {ids[node]}\n"


def _joined(numbers: Sequence[float]) -> str:
    return " ".join(map(repr, numbers))


def _graph_of(elements: Elements, nodes: dict[int, int]) -> PoseGraph:
    graph = PoseGraph()
    for vertex in nodes:
        x, y, theta = elements.vertices[vertex]
        graph.add_node((x, y, wrap_angle(theta)))
    values = np.array([numbers for _, _, numbers in elements.edges]).reshape(-1, 9)
    measurements = np.column_stack((values[:, :2], wrap_angles(values[:, 2])))
    information, least = _semidefinite(rotated(symmetric(values[:, 3:]), measurements[:, 2]))
    ids = list(nodes)
    for edge, (number, ends, _) in enumerate(elements.edges):
        unknown = [end for end in ends if end not in nodes]
        if unknown:
            raise InvalidGraph(f"line {number}: no {VERTEX} defines {unknown[0]}")
        first, second = (nodes[end] for end in ends)
        if first == second:
            raise InvalidGraph(f"line {number}: edge from vertex {ends[0]} to itself")
        if least[edge] < -ROUNDED:
            order = f" in the order of TORO, {TORO_ORDER}" if number in elements.of_toro else ""
            raise InvalidGraph(f"line {number}: the information matrix is not positive semidefinite{order}")
        is_next = abs(second - first) == 1 and _chain(ids[first]) == _chain(ids[second])
        kind = EdgeKind.ODOMETRY if is_next else EdgeKind.CLOSURE
        graph.add_edge(first, second, measurements[edge], information[edge], kind)
    return graph


def _chain(vertex: int) -> int:
    """Return the letter and label in a key of gtsam, 0 for other ids."""
    return max(vertex, 0) >> _INDEX_BITS


def _semidefinite(information: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (m, 3, 3) matrices without their negative eigenvalues, and the least of each, by its largest number."""
    if not len(information):
        return information, np.empty(0)
    values, vectors = np.linalg.eigh(information)
    largest = np.maximum(np.abs(information).max(axis=(1, 2)), np.finfo(np.float64).tiny)
    clipped = (vectors * np.maximum(values, 0.0)[:, np.newaxis]) @ vectors.transpose(0, 2, 1)
    negative = values[:, 0] < 0.0
    return np.where(negative[:, np.newaxis, np.newaxis], clipped, information), values[:, 0] / largest
