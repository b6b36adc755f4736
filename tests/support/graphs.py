"""Graphs and layouts of other programs for tests, in numbers of our own."""

import itertools
import json
from collections.abc import Mapping, Sequence
from typing import Any

from ppaas.imports.graphs.model.route_graph import GraphEdge, GraphNode, Place, RouteGraph
from ppaas.imports.report import ImportOutcome, ImportReport
from ppaas.zones.shapes import lines_of
from ppaas.zones.zone import Lane, ZoneSet

SQUARE: Mapping[int, Place] = {0: (0.0, 0.0), 1: (4.0, 0.0), 2: (4.0, 3.0), 3: (0.0, 3.0)}
"""Places of four nodes."""


def graph_of(places: Mapping[int, Place], edges: Sequence[tuple[int, int]], **limits: Any) -> RouteGraph:
    """Return a graph whose edges are pairs of nodes."""
    nodes = {str(key): GraphNode(f"p{key}", place, f"nodes[{key}]") for key, place in places.items()}
    found = [
        GraphEdge(f"e{at}", str(one), str(other), part=f"edges[{at}]", **limits)
        for at, (one, other) in enumerate(edges)
    ]
    return RouteGraph(nodes, found, [], [])


def both_ways(*edges: tuple[int, int]) -> list[tuple[int, int]]:
    """Return edges, each with its way back."""
    return [each for one, other in edges for each in ((one, other), (other, one))]


def node(number: Any, place: Sequence[Any], **properties: Any) -> dict[str, Any]:
    """Return a node of a route graph of Nav2."""
    return {
        "type": "Feature",
        "properties": {"id": number, "frame": "map"} | properties,
        "geometry": {"type": "Point", "coordinates": list(place)},
    }


def edge(number: Any, start: Any, end: Any, **properties: Any) -> dict[str, Any]:
    """Return an edge of a route graph of Nav2, without coordinates, as its own tools write it."""
    return {
        "type": "Feature",
        "properties": {"id": number, "startid": start, "endid": end} | properties,
        "geometry": {"type": "MultiLineString"},
    }


def route_graph(*features: Any, **members: Any) -> bytes:
    """Return a route graph of Nav2."""
    return json.dumps({"type": "FeatureCollection", "features": features} | members).encode()


def lif_node(name: str, x: Any, y: Any, **properties: Any) -> dict[str, Any]:
    """Return a node of a layout of LIF."""
    return {
        "nodeId": name,
        "mapId": "hall",
        "nodePosition": {"x": x, "y": y},
        "vehicleTypeNodeProperties": [{"vehicleTypeId": "tug"} | properties],
    }


def lif_edge(start: str, end: str, *vehicles: Mapping[str, Any]) -> dict[str, Any]:
    """Return an edge of a layout of LIF, with the properties of each type of vehicles."""
    given = vehicles or ({},)
    own = [{"vehicleTypeId": "tug", "rotationAllowed": True} | dict(each) for each in given]
    return {"edgeId": f"{start}-{end}", "startNodeId": start, "endNodeId": end, "vehicleTypeEdgeProperties": own}


def layout(
    nodes: Sequence[Any], edges: Sequence[Any], stations: Sequence[Any] = (), name: str = "hall"
) -> dict[str, Any]:
    """Return a layout of LIF."""
    return {"layoutId": name, "layoutVersion": "1", "nodes": nodes, "edges": edges, "stations": stations}


def lif(*layouts: Any, version: str = "1.0.0") -> bytes:
    """Return a file of LIF."""
    meta = {"projectIdentification": "hall", "creator": "us", "exportTimestamp": "2026-11-01T00:00:00.00Z"}
    return json.dumps({"metaInformation": meta | {"lifVersion": version}, "layouts": layouts}).encode()


def segments_of(zones: ZoneSet) -> set[tuple[Place, Place]]:
    """Return the straight parts of all lanes, each in the directions in which robots drive."""
    found: set[tuple[Place, Place]] = set()
    for zone in zones.lanes:
        assert isinstance(zone.rule, Lane)
        for line in lines_of(zone.geometry):
            places = [(x, y) for x, y in line]
            pairs = list(itertools.pairwise(places))
            found |= set(pairs) if zone.rule.one_way else {*pairs, *((other, one) for one, other in pairs)}
    return found


def texts(report: ImportReport, outcome: ImportOutcome) -> dict[str, str]:
    """Return the texts of a report by part."""
    return {entry.part: entry.text for entry in report.of(outcome)}


TAKEN, TRANSLATED, NO_EFFECT, REFUSED = ImportOutcome
