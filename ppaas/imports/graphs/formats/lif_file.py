"""Layouts of LIF 1.0.0 as files, valid by its schema."""

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any, NamedTuple

import msgspec

from ppaas.imports.graphs.model.gathered import GatheredNotes
from ppaas.imports.graphs.model.route_graph import GraphEdge, GraphNode, GraphStation, RouteGraph
from ppaas.imports.report import ImportReport

VERSION = "1.0.0"

ACTIONS: Mapping[str, tuple[str, ...]] = {
    "pick": ("pick",), "drop": ("drop",), "charge": ("startCharging", "stopCharging"), "park": ("park",),
    "wait": ("waitForTrigger",), "clean": ("clean",), "dock": ("dock",),
}  # fmt: skip
"""Actions at the node of a station, by what it is for."""


class Layout(NamedTuple):
    """What a layout is called.

    Parameters
    ----------
    map_id : str
    version : str
        Version of the layout.
    vehicle : str
        Type of the vehicles that its properties are for.
    now : float
        Time of the export [s since the epoch].
    """

    map_id: str
    version: str
    vehicle: str
    now: float


def lif_file(graph: RouteGraph, layout: Layout, report: ImportReport) -> bytes:
    """Return a graph as a file of LIF with one layout; what it cannot have is noted in the report."""
    notes = GatheredNotes()
    names = _node_ids(graph)
    stations = {station.part: station for station in graph.stations}
    tree = {
        "metaInformation": {
            "projectIdentification": layout.map_id,
            "creator": "PPaaS",
            "exportTimestamp": datetime.fromtimestamp(layout.now, UTC).strftime("%Y-%m-%dT%H:%M:%S.00Z"),
            "lifVersion": VERSION,
        },
        "layouts": [
            {
                "layoutId": layout.map_id,
                "layoutVersion": layout.version,
                "nodes": [_node(names[key], node, stations.get(key), layout) for key, node in graph.nodes.items()],
                "edges": [_edge(at, edge, names, layout, notes) for at, edge in enumerate(graph.edges)],
                "stations": [_station(station, names[station.part]) for station in graph.stations],
            }
        ],
    }
    notes.write(report)
    return msgspec.json.format(msgspec.json.encode(tree), indent=1) + b"\n"


def _node_ids(graph: RouteGraph) -> dict[str, str]:
    """Return ids of nodes: their names, which no other node has."""
    taken: set[str] = set()
    found = {}
    for key, node in graph.nodes.items():
        name = node.name if node.name not in taken else f"{node.name} {key}"
        taken.add(name)
        found[key] = name
    return found


def _node(name: str, node: GraphNode, station: GraphStation | None, layout: Layout) -> dict[str, Any]:
    properties: dict[str, Any] = {"vehicleTypeId": layout.vehicle}
    if station is not None and station.yaw is not None:
        properties["theta"] = station.yaw
    actions = [action for use in station.uses for action in ACTIONS[use]] if station is not None else []
    if actions:
        properties["actions"] = [
            {"actionType": action, "requirementType": "CONDITIONAL", "blockingType": "HARD"} for action in actions
        ]
    position = dict(zip("xy", node.place, strict=True))
    return {"nodeId": name, "mapId": layout.map_id, "nodePosition": position, "vehicleTypeNodeProperties": [properties]}


def _edge(at: int, edge: GraphEdge, names: Mapping[str, str], layout: Layout, notes: GatheredNotes) -> dict[str, Any]:
    properties: dict[str, Any] = {
        "vehicleTypeId": layout.vehicle,
        "vehicleOrientation": 0.0,
        "orientationType": "TANGENTIAL",
        "rotationAllowed": True,
    }
    if edge.max_speed is not None:
        properties["maxSpeed"] = edge.max_speed
    elif edge.percent is not None:
        notes.without_effect(f"lane {edge.name!r}", "its limit is a percentage, and LIF has limits in m/s")
    return {
        "edgeId": f"e{at}",
        "edgeName": edge.name,
        "startNodeId": names[edge.start],
        "endNodeId": names[edge.end],
        "vehicleTypeEdgeProperties": [properties],
    }


def _station(station: GraphStation, node: str) -> dict[str, Any]:
    position: dict[str, float] = dict(zip("xy", station.place, strict=True))
    if station.yaw is not None:
        position["theta"] = station.yaw
    return {
        "stationId": station.name,
        "interactionNodeIds": [node],
        "stationName": station.name,
        "stationPosition": position,
    }
