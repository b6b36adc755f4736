"""Route graphs of Nav2 (``nav2_route``, from Kilted on): GeoJSON with a point for each node and a line for each edge.

Its route server reads ``id``, ``frame``, ``metadata`` and ``operations`` of nodes, and ``id``, ``startid``, ``endid``,
``cost``, ``overridable``, ``metadata`` and ``operations`` of edges, and ignores the geometry of edges: each is the
straight line between its nodes.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec
import numpy as np

from ppaas.imports.graphs.formats.json_text import lenient_json
from ppaas.imports.graphs.model.cleaning import GraphBuilder
from ppaas.imports.graphs.model.degrees import are_degrees, metres_around
from ppaas.imports.graphs.model.gathered import GatheredNotes
from ppaas.imports.graphs.model.route_graph import (
    GraphEdge,
    GraphNode,
    GraphOptions,
    GraphStation,
    Place,
    ReadGraph,
    RouteGraph,
    points_of,
)
from ppaas.imports.report import ImportReport

LINES, POINT = ("LineString", "MultiLineString"), "Point"

ENDS = ("startid", "endid")
"""Properties of edges that name their nodes."""

_ALIASES = {"start_node": "startid", "end_node": "endid", "edge_id": "id", "start_id": "startid", "end_id": "endid"}
"""Names of properties in files of the first versions, and what they are now."""

NEAR = 0.1
"""Distance of the end of an edge without ids from its node [m]."""

SPEED, ABSOLUTE_SPEED = "speed_limit", "abs_speed_limit"
"""Metadata of edges: the limit as a part or percentage of the maximum, and in m/s."""

_FRAMES = ("map", "")

_NODE_KEYS = {"id", "frame", "metadata", "operations", "name"}
_EDGE_KEYS = {"id", *ENDS, "cost", "overridable", "metadata", "operations", "name"}
_KEYS = _NODE_KEYS | _EDGE_KEYS

_WEIGHT = "robots take the shortest way along lanes; costs have no effect"
_ROUTE_OPERATION = "operations of the route server are not run; doors and waits are tasks"


def is_route_graph(tree: Mapping[str, Any]) -> bool:
    """Return whether decoded JSON is a route graph: a collection of features with nodes and edges."""
    features = tree.get("features")
    if not isinstance(features, list):
        return False
    kinds = {str(_geometry(feature).get("type")) for feature in features if isinstance(feature, dict)}
    has_ends = any(_properties(feature).keys() >= set(ENDS) for feature in features if isinstance(feature, dict))
    return has_ends or (POINT in kinds and bool(kinds & set(LINES)))


def read_route_graph(content: bytes, report: ImportReport, options: GraphOptions) -> ReadGraph:
    """Read a route graph of Nav2.

    Raises
    ------
    InvalidInput
        It is no JSON, or positions are degrees and there is no anchor.
    """
    return route_graph_of(lenient_json(content, report), report, options)


def route_graph_of(tree: Mapping[str, Any], report: ImportReport, options: GraphOptions) -> ReadGraph:
    """Return the graph of decoded JSON; see `read_route_graph`."""
    notes = GatheredNotes()
    features = [(f"features[{at}]", each) for at, each in enumerate(tree.get("features", ()))]
    reader = _Reader(notes)
    edges = []
    for part, feature in features:
        kind = str(_geometry(feature).get("type") or "") if isinstance(feature, dict) else ""
        if kind == POINT:
            reader.read_node(part, feature)
        elif kind in LINES:
            edges.append((part, feature))
        else:
            notes.refused(part, f"a {kind or 'feature without a geometry'} is no node and no edge")
    reader.read_edges(edges)
    graph = reader.graph
    _note_crs(tree, report)
    if are_degrees([node.place for node in graph.nodes.values()], [_length(graph, edge) for edge in graph.edges]):
        graph = _in_metres(graph, options, report)
    report.taken(f"{len(graph.nodes)} nodes", "ends and corners of lanes")
    notes.write(report)
    return ReadGraph(graph, report)


class _Reader:
    def __init__(self, notes: GatheredNotes) -> None:
        self._notes = notes
        self._builder = GraphBuilder(notes)

    @property
    def graph(self) -> RouteGraph:
        return self._builder.graph

    def read_node(self, part: str, feature: Mapping[str, Any]) -> None:
        properties = _properties(feature)
        key, place = _id(properties.get("id")), _place(_geometry(feature).get("coordinates"))
        if key is None or place is None:
            self._notes.refused(part, f"this node has no {'id' if key is None else 'coordinates x, y'}")
            return
        if not self._builder.add_node(key, GraphNode(key, place, part)):
            return
        frame = properties.get("frame", "")
        if frame not in _FRAMES:
            self._notes.translated(part, f"frame {frame!r:.40} was taken as that of the map; --shift X Y YAW moves it")
        self._note_others(part, properties, _NODE_KEYS)
        metadata = properties.get("metadata")
        data = metadata if isinstance(metadata, dict) else {}
        name = properties.get("name", data.get("name"))
        if isinstance(name, str) and name.strip():
            uses = [use for use in data.get("uses", ()) if isinstance(use, str)] if "uses" in data else []
            station = GraphStation(name, place, _number(data.get("yaw")), tuple(uses), part)
            self.graph.stations.append(station)
        for each in sorted(data.keys() - {"name", "uses", "yaw"}):
            self._notes.without_effect(f"{part}.metadata.{each}", "metadata of nodes has no effect")

    def read_edges(self, edges: Sequence[tuple[str, Mapping[str, Any]]]) -> None:
        keys = list(self.graph.nodes)
        places = np.array([self.graph.nodes[key].place for key in keys]).reshape(-1, 2)
        for part, feature in edges:
            properties = _properties(feature)
            ends = [_id(properties.get(name)) for name in ENDS]
            positions = _positions(_geometry(feature).get("coordinates"))
            if None in ends:
                ends = [_nearest(places, keys, at) for at in (positions[0], positions[-1])] if positions else ends
                if None in ends:
                    self._notes.refused(part, "this edge has no 'startid' and 'endid', and ends at no node")
                    continue
                self._notes.translated(part, "it has no 'startid' and 'endid': its nodes are those where it ends")
            self._read_edge(part, properties, str(ends[0]), str(ends[1]))
            if len(positions) > 2:
                self._notes.without_effect(
                    f"{part}.geometry", "positions between its nodes: as in Nav2, an edge is straight"
                )

    def _read_edge(self, part: str, properties: Mapping[str, Any], start: str, end: str) -> None:
        key = _id(properties.get("id"))
        metadata = properties.get("metadata")
        data = metadata if isinstance(metadata, dict) else {}
        max_speed, percent = self._limits(part, data)
        edge = GraphEdge(f"edge {key}" if key else part, start, end, (), max_speed, percent, "", part)
        if not self._builder.add_edge(edge, key):
            return
        self._note_others(part, properties, _EDGE_KEYS)
        for name in ("cost", "overridable"):
            if name in properties:
                self._notes.without_effect(f"{part}.{name}", _WEIGHT)
        for each in sorted(data.keys() - {SPEED, ABSOLUTE_SPEED}):
            self._notes.without_effect(f"{part}.metadata.{each}", "metadata but limits of the speed has no effect")

    def _limits(self, part: str, data: Mapping[str, Any]) -> tuple[float | None, float | None]:
        speed, percent = _number(data.get(ABSOLUTE_SPEED)), _number(data.get(SPEED))
        if speed is not None:
            if 0.0 < speed <= 100.0:
                self._notes.taken(f"{part}.metadata.{ABSOLUTE_SPEED}", f"{speed:g} m/s")
            else:
                self._notes.without_effect(f"{part}.metadata.{ABSOLUTE_SPEED}", f"{speed:g} m/s is no limit")
                speed = None
        if percent is None:
            return speed, None
        name = f"{part}.metadata.{SPEED}"
        if 0.0 < percent < 1.0:
            self._notes.translated(
                name, f"{percent:g} is a part of the maximum, as Nav2's DistanceScorer reads it: {100.0 * percent:g} %"
            )
            return speed, round(100.0 * percent, 4)
        if 1.0 < percent < 100.0:
            self._notes.taken(name, f"{percent:g} %, as Nav2's AdjustSpeedLimit reads it")
            return speed, percent
        self._notes.without_effect(name, f"{percent:g} is no limit")
        return speed, None

    def _note_others(self, part: str, properties: Mapping[str, Any], known: set[str]) -> None:
        operations = properties.get("operations")
        for each in operations if isinstance(operations, dict | list) else ():
            name = each if isinstance(each, str) else str(_mapping(each).get("type", "operation"))
            self._notes.without_effect(f"{part}.operations.{name}", _ROUTE_OPERATION)
        for each in sorted(properties.keys() - known):
            self._notes.without_effect(f"{part}.{each}", "no property that the route server reads")


def _in_metres(graph: RouteGraph, options: GraphOptions, report: ImportReport) -> RouteGraph:
    places = [node.place for node in graph.nodes.values()]
    metres = metres_around(places, options.anchor, report.source)
    report.translated("positions", "longitudes and latitudes, in metres around the anchor")
    moved = dict(zip(places, metres, strict=True))
    replace = msgspec.structs.replace
    return RouteGraph(
        {key: replace(node, place=moved[node.place]) for key, node in graph.nodes.items()},
        graph.edges,
        [replace(station, place=moved[station.place]) for station in graph.stations],
    )


def _note_crs(tree: Mapping[str, Any], report: ImportReport) -> None:
    crs = tree.get("crs")
    if crs is not None:
        name = _mapping(_mapping(crs).get("properties")).get("name", "")
        report.without_effect("crs", f"{name!s:.60}: route graphs of robots are in metres in the frame of the map")


def _length(graph: RouteGraph, edge: GraphEdge) -> float:
    start, end = points_of(graph, edge)
    return math.dist(start, end)


def _geometry(feature: Any) -> Mapping[str, Any]:
    return _mapping(_mapping(feature).get("geometry"))


def _properties(feature: Any) -> Mapping[str, Any]:
    given = _mapping(_mapping(feature).get("properties"))
    return {_name_of(key): value for key, value in given.items()}


def _name_of(key: str) -> str:
    lower = key.lower()
    return _ALIASES.get(lower, lower if lower in _KEYS else key)


def _mapping(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, dict) else {}


def _id(value: Any) -> str | None:
    if isinstance(value, bool) or value is None:
        return None
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    return str(value).strip() or None


def _number(value: Any) -> float | None:
    try:
        number = float(value) if not isinstance(value, bool) else math.nan
    except (TypeError, ValueError):
        return None
    return number if math.isfinite(number) else None


def _place(value: Any) -> Place | None:
    if not isinstance(value, list) or len(value) < 2:
        return None
    x, y = _number(value[0]), _number(value[1])
    return None if x is None or y is None else (x, y)


def _positions(value: Any) -> list[Place]:
    """Return the positions of a line or of the lines of one edge."""
    if not isinstance(value, list):
        return []
    if value and isinstance(value[0], list) and value[0] and isinstance(value[0][0], list):
        return [place for line in value for place in _positions(line)]
    return [place for each in value if (place := _place(each)) is not None]


def _nearest(places: Any, keys: Sequence[str], at: Place) -> str | None:
    if not len(places):
        return None
    apart = np.hypot(*(places - at).T)
    nearest = int(apart.argmin())
    return keys[nearest] if apart[nearest] <= NEAR else None


# -- files -------------------------------------------------------------------------------------------------------------

CRS = "urn:ogc:def:crs:EPSG::3857"
"""Coordinate system that the tools of Nav2 write, with positions in metres in the frame of the map."""


def nav2_route_file(graph: RouteGraph, name: str) -> bytes:
    """Return a graph as a route graph of Nav2.

    Numbers of nodes and edges are unique together. Limits of the speed are numbers with a point, since Nav2 takes
    others for no limit.
    """
    numbers = {key: number for number, key in enumerate(graph.nodes)}
    stations = {station.part: station for station in graph.stations}
    features = [
        _feature("Point", list(node.place), {"id": numbers[key], "frame": "map", **_metadata_of(stations.get(key))})
        for key, node in graph.nodes.items()
    ]
    for number, edge in enumerate(graph.edges, len(numbers)):
        line = [[list(graph.nodes[key].place) for key in (edge.start, edge.end)]]
        ends = dict(zip(ENDS, (numbers[edge.start], numbers[edge.end]), strict=True))
        features.append(_feature("MultiLineString", line, {"id": number, **ends, **_limits_of(edge)}))
    tree = {
        "type": "FeatureCollection",
        "name": name,
        "crs": {"type": "name", "properties": {"name": CRS}},
        "features": features,
    }
    return msgspec.json.format(msgspec.json.encode(tree), indent=1) + b"\n"


def _feature(kind: str, coordinates: list[Any], properties: dict[str, Any]) -> dict[str, Any]:
    geometry = {"type": kind, "coordinates": coordinates}
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def _metadata_of(station: GraphStation | None) -> dict[str, Any]:
    if station is None:
        return {}
    found: dict[str, Any] = {"name": station.name}
    if station.uses:
        found["uses"] = list(station.uses)
    if station.yaw is not None:
        found["yaw"] = float(station.yaw)
    return {"metadata": found}


def _limits_of(edge: GraphEdge) -> dict[str, Any]:
    limits = {SPEED: edge.percent, ABSOLUTE_SPEED: edge.max_speed}
    found = {name: float(limit) for name, limit in limits.items() if limit is not None}
    return {"metadata": found} if found else {}
