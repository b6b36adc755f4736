"""Pose graphs as text in the format of g2o (Kümmerle et al., ICRA 2011): VERTEX_SE2, EDGE_SE2, FIX.

g2o measures errors in the frame of the measured pose, so that the information of a file is in the frame of an edge's
second node; that of `PoseGraph` is in the frame of the first.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from ppaas.errors import InvalidGraph
from ppaas.geometry import wrap_angle
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.planar_poses import rotated, symmetric, upper_triangle, wrap_angles

_NUMBERS = {"VERTEX_SE2": (1, 3), "EDGE_SE2": (2, 9)}
"""Ids and numbers after each tag."""

_IGNORED = ("FIX", "ROBOTLASER1", "PARAMS_SE2OFFSET")
"""Tags of lines that do not change the graph: the first node is fixed, and scans are not read."""


@dataclass
class _Elements:
    """Vertices by id, and edges with the numbers of their lines."""

    vertices: dict[int, tuple[float, ...]] = field(default_factory=dict)
    edges: list[tuple[int, tuple[int, ...], tuple[float, ...]]] = field(default_factory=list)


def parse_g2o(lines: Iterable[str]) -> PoseGraph:
    """Return the graph of the lines of a file; nodes are in order of their ids.

    An edge from an id to the next is odometry, any other a closure. Lines FIX have no effect, since the first
    node is fixed, and neither have scans (ROBOTLASER1).

    Raises
    ------
    InvalidGraph
        A line is malformed, repeats a vertex, names an unknown one, or has an information matrix that is not positive
        semidefinite; or there is no vertex. The text names the number of the line.
    """
    elements = _Elements()
    for number, line in enumerate(lines, 1):
        words = line.split("#", 1)[0].split()
        if words and words[0] not in _IGNORED:
            _read(elements, number, words)
    if not elements.vertices:
        raise InvalidGraph("the graph has no VERTEX_SE2")
    return _graph_of(elements)


def format_g2o(graph: PoseGraph) -> Iterator[str]:
    """Yield the lines of a graph, each with its newline; node 0 is fixed."""
    for node, pose in enumerate(graph.poses.tolist()):
        yield f"VERTEX_SE2 {node} {_joined(pose)}\n"
    if graph.node_count:
        yield "FIX 0\n"
    edges = graph.edges
    information = upper_triangle(rotated(edges.information, -edges.measurements[:, 2]))
    numbers = np.concatenate((edges.measurements, information), axis=1).tolist()
    for first, second, row in zip(edges.first.tolist(), edges.second.tolist(), numbers, strict=True):
        yield f"EDGE_SE2 {first} {second} {_joined(row)}\n"


def _joined(numbers: list[float]) -> str:
    return " ".join(map(repr, numbers))


def _read(elements: _Elements, number: int, words: list[str]) -> None:
    """Add the vertex or edge of a line."""
    tag = words[0]
    if tag not in _NUMBERS:
        raise InvalidGraph(f"line {number}: unknown element {tag[:40]!r}; known: VERTEX_SE2, EDGE_SE2, FIX")
    id_count, number_count = _NUMBERS[tag]
    if len(words) != 1 + id_count + number_count:
        raise InvalidGraph(f"line {number}: {tag} takes {id_count + number_count} values, got {len(words) - 1}")
    try:
        ids = tuple(int(word) for word in words[1 : 1 + id_count])
        numbers = tuple(float(word) for word in words[1 + id_count :])
    except ValueError as error:
        raise InvalidGraph(f"line {number}: {tag} takes integer ids, then numbers") from error
    if not all(map(math.isfinite, numbers)):
        raise InvalidGraph(f"line {number}: {tag} has a number that is not finite")
    if tag == "EDGE_SE2":
        elements.edges.append((number, ids, numbers))
    elif elements.vertices.setdefault(ids[0], numbers) is not numbers:
        raise InvalidGraph(f"line {number}: vertex {ids[0]} is defined twice")


def _graph_of(elements: _Elements) -> PoseGraph:
    graph, nodes = PoseGraph(), {}
    for vertex in sorted(elements.vertices):
        x, y, theta = elements.vertices[vertex]
        nodes[vertex] = graph.add_node((x, y, wrap_angle(theta)))
    values = np.array([numbers for _, _, numbers in elements.edges]).reshape(-1, 9)
    measurements = np.column_stack((values[:, :2], wrap_angles(values[:, 2])))
    information = rotated(symmetric(values[:, 3:]), measurements[:, 2])
    least = np.linalg.eigvalsh(information)[:, 0] if len(values) else values[:, 0]
    for edge, (number, ends, _) in enumerate(elements.edges):
        unknown = [end for end in ends if end not in nodes]
        if unknown:
            raise InvalidGraph(f"line {number}: no VERTEX_SE2 defines {unknown[0]}")
        if ends[0] == ends[1]:
            raise InvalidGraph(f"line {number}: edge from vertex {ends[0]} to itself")
        if least[edge] < -1e-9 * np.abs(information[edge]).max():
            raise InvalidGraph(f"line {number}: the information matrix is not positive semidefinite")
        kind = EdgeKind.ODOMETRY if ends[1] == ends[0] + 1 else EdgeKind.CLOSURE
        graph.add_edge(nodes[ends[0]], nodes[ends[1]], measurements[edge], information[edge], kind)
    return graph
