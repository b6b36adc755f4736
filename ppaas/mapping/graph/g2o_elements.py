"""Elements in the lines of a pose graph: of g2o (Kümmerle et al., ICRA 2011) and of TORO (Grisetti et al., 2007).

An element that is not one of a graph of poses in the plane, such as a landmark, is counted and left out.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TypeVar

from ppaas.errors import InvalidGraph

Number = TypeVar("Number", int, float)

VERTEX, EDGE, FIX = "VERTEX_SE2", "EDGE_SE2", "FIX"

_TORO = {"VERTEX2": VERTEX, "EDGE2": EDGE}
"""Tags of TORO, and g2o's tags for the same elements."""

_OF_TORO = (0, 1, 2, 3, 4, 7, 5, 8, 6)
"""Numbers of an edge of TORO in the order of g2o."""

TORO_ORDER = "xx xy yy θθ xθ yθ"
"""Order of the information of an edge of TORO; g2o's is xx xy xθ yy yθ θθ."""

_NUMBERS = {VERTEX: (1, 3), EDGE: (2, 9)}
"""Ids and numbers after each tag."""

_WITHOUT_EFFECT = ("ROBOTLASER", "RAWLASER", "PARAMS_")
"""Beginnings of the tags of lines that do not change the poses: scans, and parameters of edges that are left out."""

_IN_SPACE = ("VERTEX_SE3", "EDGE_SE3", "VERTEX3", "EDGE3", "VERTEX_SIM3", "EDGE_SIM3")
"""Beginnings of the tags of poses in space."""


@dataclass
class LeftOut:
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
    left_out : dict of str to LeftOut
        Lines that were left out, by tag.
    of_toro : set of int
        Numbers of the lines of edges of TORO.
    """

    vertices: dict[int, tuple[float, ...]] = field(default_factory=dict)
    edges: list[tuple[int, tuple[int, ...], tuple[float, ...]]] = field(default_factory=list)
    fixed: dict[int, int] = field(default_factory=dict)
    left_out: dict[str, LeftOut] = field(default_factory=dict)
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
    """Add the element of a line."""
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
        elements.left_out.setdefault(tag[:40], LeftOut(number)).count += 1


def _add(elements: Elements, number: int, words: list[str]) -> None:
    """Add a vertex or an edge."""
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
