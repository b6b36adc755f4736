"""Graph of routes: nodes in the plane, directed edges between them, and stations; what all formats are read into."""

import math
from typing import Literal, NamedTuple

import msgspec

from ppaas.imports.report import ImportReport

MAX_FILE = 32 << 20
"""Limit of the size of a file [bytes]."""

SAME = 1e-3
"""Distance below which two nodes are one place [m]."""

Place = tuple[float, float]
"""x, y [m]."""


class GraphNode(msgspec.Struct, frozen=True):
    """Node of a graph.

    Parameters
    ----------
    name : str
        What its file calls it.
    place : tuple of float
        x, y [m] in the frame of the map.
    part : str
        Where it is in the file.
    """

    name: str
    place: Place
    part: str = ""


class GraphEdge(msgspec.Struct, frozen=True):
    """Edge along which robots drive from one node to another; a way back is another edge.

    Parameters
    ----------
    name : str
        What its file calls it.
    start, end : str
        Keys of its nodes.
    between : tuple of Place
        Positions between its nodes, of a curve.
    max_speed, percent : float, optional
        Limit of the speed: [m/s], and of the robot's maximum.
    group : str
        Robots are on edges of one group one at a time; none if empty.
    part : str
        Where it is in the file.
    """

    name: str
    start: str
    end: str
    between: tuple[Place, ...] = ()
    max_speed: float | None = None
    percent: float | None = None
    group: str = ""
    part: str = ""


class GraphStation(msgspec.Struct, frozen=True):
    """Named place.

    Parameters
    ----------
    name : str
    place : tuple of float
        x, y [m].
    yaw : float, optional
        Heading of a robot that stands there [rad].
    uses : tuple of str
        What it is for, as `ppaas.zones.zone.Station` has it.
    part : str
        Where it is in the file.
    """

    name: str
    place: Place
    yaw: float | None = None
    uses: tuple[str, ...] = ()
    part: str = ""


class GraphMark(msgspec.Struct, frozen=True):
    """Door, car of a lift, or dock, as zones of maps have them.

    Parameters
    ----------
    name : str
    kind : str
    places : tuple of Place
        Both ends of a door, the corners of a car, the place of a dock.
    lift : str
        Lift of a door or a car.
    yaw : float, optional
        Heading of a robot in a dock [rad].
    charges : bool
        Whether a dock charges.
    part : str
        Where it is in the file.
    """

    name: str
    kind: Literal["door", "lift", "dock"]
    places: tuple[Place, ...]
    lift: str = ""
    yaw: float | None = None
    charges: bool = True
    part: str = ""


class RouteGraph(msgspec.Struct):
    """Graph of one floor.

    Parameters
    ----------
    nodes : dict of str to GraphNode
        By a key that is unique in the file.
    edges : list of GraphEdge
        Their nodes are all in ``nodes``.
    stations : list of GraphStation
    passing : list of Place
        Places where robots do not stop.
    marks : list of GraphMark
    """

    nodes: dict[str, GraphNode] = {}
    edges: list[GraphEdge] = []
    stations: list[GraphStation] = []
    passing: list[Place] = []
    marks: list[GraphMark] = []


class GraphOptions(msgspec.Struct, frozen=True):
    """Choices of who imports a graph.

    Parameters
    ----------
    level : str, optional
        Name of the floor or layout, where a file has several.
    graph : int, optional
        Number of the graph of a building of Open-RMF, which may have one for each fleet; all if None.
    vehicle : str, optional
        Type of the vehicles of a layout of LIF; all if None.
    layers : tuple of str
        Layers of a drawing that have the lanes.
    scale : float, optional
        Metres per unit of a file that does not have one, or has a wrong one.
    anchor : tuple of float, optional
        Latitude and longitude of x = 0, y = 0 of the map [°], for files in degrees.
    shift : tuple of float
        x, y [m] and yaw [rad] of the origin of the graph in the frame of the map.
    radius : float, optional
        Radius of the largest robots [m], for which lanes are joined and left out; None leaves them as they are.
    """

    level: str | None = None
    graph: int | None = None
    vehicle: str | None = None
    layers: tuple[str, ...] = ()
    scale: float | None = None
    anchor: tuple[float, float] | None = None
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    radius: float | None = None


NO_OPTIONS = GraphOptions()


class ReadGraph(NamedTuple):
    """Graph of a file, and the report of its parts."""

    graph: RouteGraph
    report: ImportReport


def moved(graph: RouteGraph, shift: tuple[float, float, float]) -> RouteGraph:
    """Return a graph whose origin is at x, y [m] and yaw [rad] of another frame, in that frame."""
    x, y, yaw = shift
    if shift == (0.0, 0.0, 0.0):
        return graph
    cosine, sine = math.cos(yaw), math.sin(yaw)

    def move(place: Place) -> Place:
        return x + cosine * place[0] - sine * place[1], y + sine * place[0] + cosine * place[1]

    replace = msgspec.structs.replace
    return RouteGraph(
        {key: replace(node, place=move(node.place)) for key, node in graph.nodes.items()},
        [replace(edge, between=tuple(map(move, edge.between))) for edge in graph.edges],
        [
            replace(station, place=move(station.place), yaw=None if station.yaw is None else wrapped(station.yaw + yaw))
            for station in graph.stations
        ],
        [move(place) for place in graph.passing],
        [
            replace(
                mark, places=tuple(map(move, mark.places)), yaw=None if mark.yaw is None else wrapped(mark.yaw + yaw)
            )
            for mark in graph.marks
        ],
    )


def wrapped(angle: float) -> float:
    """Return an angle from -π to π [rad]."""
    return math.atan2(math.sin(angle), math.cos(angle))


def points_of(graph: RouteGraph, edge: GraphEdge) -> list[Place]:
    """Return the positions of an edge, from its start to its end."""
    return [graph.nodes[edge.start].place, *edge.between, graph.nodes[edge.end].place]
