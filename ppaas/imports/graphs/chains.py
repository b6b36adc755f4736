"""Chains: edges of a graph, joined to the lines that a person would draw as lanes."""

from collections.abc import Iterator
from typing import NamedTuple

import msgspec

from ppaas.fleet.lane_drawing import JOINS
from ppaas.imports.graphs.model.gathered import GatheredNotes
from ppaas.imports.graphs.model.route_graph import SAME, GraphEdge, Place, RouteGraph, points_of

_ONE_PLACE = "its ends are less than 0.1 m apart, one place for robots: no lane is needed"
assert JOINS == 0.1


class Link(msgspec.Struct):
    """Line between two places, along which robots drive one way or both ways.

    Parameters
    ----------
    start, end : int
        Numbers of the places.
    points : list of Place
        Positions from the start to the end [m].
    one_way : bool
        Whether robots drive only from the start to the end.
    name : str
    max_speed, percent : float, optional
        The lowest limit of its edges.
    groups : tuple of str
        Groups of edges on which one robot is at a time.
    """

    start: int
    end: int
    points: list[Place]
    one_way: bool
    name: str
    max_speed: float | None = None
    percent: float | None = None
    groups: tuple[str, ...] = ()


class LinkedPlaces(NamedTuple):
    """Places of a graph, and the links between them.

    Parameters
    ----------
    names : list of str
        Name of each place, of its first node.
    links : list of Link
    """

    names: list[str]
    links: list[Link]


def links_of(graph: RouteGraph, notes: GatheredNotes) -> LinkedPlaces:
    """Return the links of a graph: nodes in one place are one, and edges back and forth on one line are one.

    Parameters
    ----------
    graph : RouteGraph
    notes : GatheredNotes
        Takes edges that are no line, and those that lie on others.
    """
    numbers: dict[tuple[int, int], int] = {}
    names: list[str] = []
    places: dict[str, int] = {}
    for key, node in graph.nodes.items():
        at = round(node.place[0] / SAME), round(node.place[1] / SAME)
        if at not in numbers:
            numbers[at] = len(names)
            names.append(node.name)
        places[key] = numbers[at]
    found: dict[tuple[int, int, tuple[Place, ...]], Link] = {}
    for edge in graph.edges:
        start, end = places[edge.start], places[edge.end]
        points = _without_repeats(points_of(graph, edge))
        if start == end or (len(points) == 2 and _length(points) <= JOINS):
            notes.without_effect(edge.part, _ONE_PLACE)
            continue
        forth = start, end, tuple(points[1:-1])
        back = end, start, tuple(points[-2:0:-1])
        if link := found.get(forth):
            notes.translated(edge.part, "lies on another edge: one lane for both, with the lower limits")
        elif link := found.get(back):
            link.one_way = False
        else:
            found[forth] = link = Link(start, end, points, one_way=True, name=edge.name)
        _take_limits(link, edge)
    return LinkedPlaces(names, list(found.values()))


def _without_repeats(points: list[Place]) -> list[Place]:
    kept = points[:1]
    for point in points[1:-1]:
        if abs(point[0] - kept[-1][0]) + abs(point[1] - kept[-1][1]) > SAME:
            kept.append(point)
    return [*kept, points[-1]]


def _length(points: list[Place]) -> float:
    (x0, y0), (x1, y1) = points[0], points[-1]
    return float(((x1 - x0) ** 2 + (y1 - y0) ** 2) ** 0.5)


def _take_limits(link: Link, edge: GraphEdge) -> None:
    link.max_speed = _lower(link.max_speed, edge.max_speed)
    link.percent = _lower(link.percent, edge.percent)
    if edge.group and edge.group not in link.groups:
        link.groups = (*link.groups, edge.group)


def _lower(one: float | None, other: float | None) -> float | None:
    return other if one is None or (other is not None and other < one) else one


class LaneChain(NamedTuple):
    """Links one after the other, between which nothing branches off.

    Parameters
    ----------
    places : list of int
    links : list of Link
        In the direction of the chain.
    one_way : bool
    """

    places: list[int]
    links: list[Link]
    one_way: bool

    @property
    def points(self) -> list[Place]:
        """Positions from its start to its end [m]."""
        first, *others = self.links
        return [*first.points, *(point for link in others for point in link.points[1:])]

    @property
    def size(self) -> int:
        """Number of its positions."""
        return sum(len(link.points) - 1 for link in self.links) + 1


def chains_of(links: list[Link]) -> list[LaneChain]:
    """Return the chains of links, in the order of the first link of each."""
    near: dict[int, list[int]] = {}
    for number, link in enumerate(links):
        near.setdefault(link.start, []).append(number)
        near.setdefault(link.end, []).append(number)
    left = set(range(len(links)))
    found = []
    for number, link in enumerate(links):
        if number not in left:
            continue
        left.discard(number)
        behind = list(_walk(links, near, left, link.end, number, forth=True))
        before = [] if behind and behind[-1].end == link.start else _before(links, near, left, link, number)
        ordered = [*before, link, *behind]
        found.append(LaneChain([ordered[0].start, *(each.end for each in ordered)], ordered, link.one_way))
    return found


def _before(links: list[Link], near: dict[int, list[int]], left: set[int], link: Link, number: int) -> list[Link]:
    return [_reversed(each) for each in _walk(links, near, left, link.start, number, forth=False)][::-1]


def _walk(
    links: list[Link], near: dict[int, list[int]], left: set[int], here: int, number: int, *, forth: bool
) -> Iterator[Link]:
    """Yield the links that go on from a place, turned so that they lead away from it; each is taken out of ``left``."""
    one_way = links[number].one_way
    while len(near[here]) == 2:
        [onward] = [each for each in near[here] if each != number] or [number]
        link = links[onward]
        if onward not in left or link.one_way != one_way:
            return
        if one_way and (link.start if forth else link.end) != here:
            return
        left.discard(onward)
        turned = link if link.start == here else _reversed(link)
        yield turned
        here, number = turned.end, onward


def _reversed(link: Link) -> Link:
    return msgspec.structs.replace(link, start=link.end, end=link.start, points=link.points[::-1])
