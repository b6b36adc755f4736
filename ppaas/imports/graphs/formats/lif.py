"""Layouts of LIF, the Layout Interchange Format of the VDMA, which goes with VDA 5050.

A layout is one floor. Its edges lead one way, have limits for each type of vehicles, and may be curves; its stations
name the nodes where vehicles do something.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from ppaas.errors import InvalidInput
from ppaas.imports.graphs.formats.json_text import lenient_json
from ppaas.imports.graphs.formats.lif_fields import checked_fields, field, number, objects, text
from ppaas.imports.graphs.formats.lif_names import as_before
from ppaas.imports.graphs.model.cleaning import GraphBuilder
from ppaas.imports.graphs.model.gathered import GatheredNotes
from ppaas.imports.graphs.model.route_graph import (
    GraphEdge,
    GraphNode,
    GraphOptions,
    GraphStation,
    Place,
    ReadGraph,
    wrapped,
)
from ppaas.imports.report import ImportReport

USES: Mapping[str, str] = {
    "pick": "pick", "drop": "drop", "startcharging": "charge", "stopcharging": "charge", "park": "park",
    "waitfortrigger": "wait", "clean": "clean", "dock": "dock",
}  # fmt: skip
"""What a station is for, by the actions at its nodes, in small letters."""

_WITHOUT_EFFECT: Mapping[str, str] = {
    "vehicleOrientation": "robots choose their heading along lanes",
    "vehicleOrientations": "robots choose their heading along lanes",
    "orientationType": "robots choose their heading along lanes",
    "rotationAllowed": "robots turn where they must",
    "rotationAtStartNodeAllowed": "robots turn where they must",
    "rotationAtEndNodeAllowed": "robots turn where they must",
    "reachOrientationBeforeEntering": "robots turn where they must",
    "maxRotationSpeed": "zones limit the speed only, not the rotation",
    "minHeight": "zones have no heights",
    "maxHeight": "zones have no heights",
    "loadRestriction": "zones do not depend on the load",
    "actions": "actions on the way are not run; tasks go to stations",
    "reentryAllowed": "robots may begin anywhere on a lane",
    "allowedDeviationXY": "robots stay on the lane, within the margin of the traffic",
    "corridor": "robots stay on the lane, within the margin of the traffic",
    "physicalLineGuided": "robots are guided by their map",
    "physicalLineGuidedProperty": "robots are guided by their map",
}

END_NEAR = 0.1
"""Distance of the ends of a curve from the nodes of its edge [m]."""


def is_layout(tree: Mapping[str, Any]) -> bool:
    """Return whether decoded JSON is a file of LIF."""
    is_whole = isinstance(tree.get("layouts"), list) or isinstance(tree.get("origins"), list)
    return is_whole or {"nodes", "edges", "layoutId"} <= tree.keys()


def read_lif(content: bytes, report: ImportReport, options: GraphOptions) -> ReadGraph:
    """Read a layout of LIF; what breaks the schema is reported, and read if it can be.

    Raises
    ------
    InvalidInput
        It is no JSON, or has no such layout.
    """
    return lif_graph_of(lenient_json(content, report), report, options)


def lif_graph_of(tree: Mapping[str, Any], report: ImportReport, options: GraphOptions) -> ReadGraph:
    """Return the graph of decoded JSON; see `read_lif`."""
    notes = GatheredNotes()
    tree = as_before(tree if {"layouts", "origins"} & tree.keys() else {"layouts": [tree]}, report)
    tree = checked_fields(tree, notes)
    version = text(field(tree, "metaInformation"), "lifVersion")
    report.taken("lifVersion", f"{version or 'none'}; read as 0.11 to 2.0")
    at, layout = _chosen(objects(tree, "layouts"), options, report)
    reader = _Reader(notes, f"layouts[{at}]", options)
    reader.read(layout, _other_nodes(tree, at))
    report.taken(f"{len(reader.builder.graph.nodes)} nodes", "ends and corners of lanes")
    notes.write(report)
    return ReadGraph(reader.builder.graph, report)


def _chosen(
    layouts: Sequence[tuple[int, Mapping[str, Any]]], options: GraphOptions, report: ImportReport
) -> tuple[int, Mapping[str, Any]]:
    if not layouts:
        raise InvalidInput(f"{report.source} has no layouts")
    names = [_names(layout) for _, layout in layouts]
    listed = ", ".join(each[0] for each in names)
    if options.level is None:
        chosen = 0
    else:
        chosen = next((at for at, each in enumerate(names) if options.level in each), -1)
        if chosen < 0:
            raise InvalidInput(f"{report.source} has no layout {options.level!r}: it has {listed}")
    for number_of, (at, _) in enumerate(layouts):
        if number_of != chosen:
            name = names[number_of][0]
            report.without_effect(f"layouts[{at}]", f"{name}: another floor or part; import it with --level {name}")
    return layouts[chosen]


def _names(layout: Mapping[str, Any]) -> list[str]:
    names = [text(layout, name) for name in ("layoutId", "layoutLevelId", "layoutName")]
    return [name for name in names if name] or [""]


def _other_nodes(tree: Mapping[str, Any], chosen: int) -> set[str]:
    others = [layout for at, layout in objects(tree, "layouts") if at != chosen]
    return {text(node, "nodeId") for layout in others for _, node in objects(layout, "nodes")}


class _Reader:
    def __init__(self, notes: GatheredNotes, part: str, options: GraphOptions) -> None:
        self.builder = GraphBuilder(notes)
        self._notes, self._part, self._vehicle = notes, part, options.vehicle
        self._uses: dict[str, list[str]] = {}
        self._yaws: dict[str, float] = {}

    def read(self, layout: Mapping[str, Any], elsewhere: set[str]) -> None:
        for at, node in objects(layout, "nodes"):
            self._read_node(f"{self._part}.nodes[{at}]", node)
        for at, edge in objects(layout, "edges"):
            part = f"{self._part}.edges[{at}]"
            end = text(edge, "endNodeId")
            if end in elsewhere and end not in self.builder.graph.nodes:
                self._notes.without_effect(part, "leads to another layout: robots do not change floors")
            else:
                self._read_edge(part, edge)
        named: set[str] = set()
        for at, station in objects(layout, "stations"):
            named |= self._read_station(f"{self._part}.stations[{at}]", station)
        for key, uses in self._uses.items():
            if key not in named and "charge" in uses:
                part = self.builder.graph.nodes[key].part
                self._add_station(key, key, f"{part}.vehicleTypeNodeProperties")

    def _of_vehicle(self, given: Mapping[str, Any], name: str) -> list[tuple[int, Mapping[str, Any]]]:
        found = objects(given, name)
        if self._vehicle is None:
            return found
        return [(at, each) for at, each in found if text(each, "vehicleTypeId") == self._vehicle]

    def _read_node(self, part: str, given: Mapping[str, Any]) -> None:
        key, position = text(given, "nodeId"), field(given, "nodePosition")
        x, y = number(position, "x"), number(position, "y")
        if not key or x is None or y is None:
            self._notes.refused(part, "it has no nodeId" if not key else "its nodePosition has no numbers x and y")
            return
        if not self.builder.add_node(key, GraphNode(key, (x, y), part)):
            return
        for _, properties in self._of_vehicle(given, "vehicleTypeNodeProperties"):
            self._read_heading(key, part, properties)
            for name in ("loadRestriction", "allowedDeviationXY"):
                if field(properties, name) is not None:
                    self._notes.without_effect(f"{part}.{name}", _WITHOUT_EFFECT[name])
            self._read_actions(key, part, properties)

    def _read_heading(self, key: str, part: str, properties: Mapping[str, Any]) -> None:
        yaw = number(properties, "theta")
        if yaw is None:
            return
        if abs(yaw) > math.tau:
            self._notes.refused(f"{part}.theta", f"{yaw:g} is no angle in radians, which are from -3.14 to 3.14")
        else:
            self._yaws.setdefault(key, wrapped(yaw))

    def _read_actions(self, key: str, part: str, properties: Mapping[str, Any]) -> None:
        for _, action in objects(properties, "actions"):
            kind = text(action, "actionType")
            if use := USES.get(kind.lower()):
                self._uses.setdefault(key, []).append(use)
            else:
                self._notes.without_effect(f"{part} action {kind or '?'}", "no use of a station is meant by it")

    # -- edges ---------------------------------------------------------------------------------------------------------

    def _read_edge(self, part: str, given: Mapping[str, Any]) -> None:
        key, start, end = text(given, "edgeId"), text(given, "startNodeId"), text(given, "endNodeId")
        every = objects(given, "vehicleTypeEdgeProperties")
        properties = self._of_vehicle(given, "vehicleTypeEdgeProperties")
        if every and not properties:
            self._notes.without_effect(part, f"not for vehicles of the type {self._vehicle}")
            return
        limits = [limit for _, each in properties if (limit := number(each, "maxSpeed")) is not None]
        low = min((limit for limit in limits if 0.0 < limit <= 100.0), default=None)
        curves = [
            curve
            for at, each in properties
            if "trajectory" in each and (curve := self._curve(f"{part} of {at}", each)) is not None
        ]
        between: tuple[Place, ...] = ()
        if curves:
            between = self._between(part, curves[0], start, end)
        edge = GraphEdge(key or part, start, end, between, low, None, "", part)
        if not self.builder.add_edge(edge, key or None):
            return
        if low is not None:
            several = ", the lowest of its types of vehicles" if len(set(limits)) > 1 else ""
            self._notes.translated(f"{part}.maxSpeed", f"a zone that limits the speed to {low:g} m/s{several}")
        for _, each in properties:
            for name in each:
                if name in _WITHOUT_EFFECT:
                    self._notes.without_effect(f"{part}.{name}", _WITHOUT_EFFECT[name])

    def _curve(self, part: str, properties: Mapping[str, Any]) -> list[Place] | None:
        given = field(properties, "trajectory")
        if not isinstance(given, dict):
            return None
        points = [tuple(_control(point)) for _, point in objects(given, "controlPoints")]
        knots = field(given, "knotVector")
        degree = number(given, "degree")
        try:
            if not isinstance(knots, list) or any(math.isnan(each) for point in points for each in point):
                raise ValueError("it needs numbers as knots and control points")
            values = [float(knot) for knot in knots]
            return _positions(values, [(x, y, w) for x, y, w in points], int(1 if degree is None else degree))
        except (ValueError, TypeError) as error:
            self._notes.refused(f"{part}.trajectory", f"{error}; the edge is straight instead")
            return None

    def _between(self, part: str, curve: list[Place], start: str, end: str) -> tuple[Place, ...]:
        nodes = self.builder.graph.nodes
        if start not in nodes or end not in nodes:
            return ()
        if max(math.dist(curve[0], nodes[start].place), math.dist(curve[-1], nodes[end].place)) > END_NEAR:
            self._notes.refused(
                f"{part}.trajectory", "the curve does not lead from the start to the end of the edge; it is straight"
            )
            return ()
        self._notes.translated(f"{part}.trajectory", "a curve, as a lane with corners 2 cm beside it at most")
        return tuple(curve[1:-1])

    # -- stations ------------------------------------------------------------------------------------------------------

    def _read_station(self, part: str, given: Mapping[str, Any]) -> set[str]:
        """Add a station for each of the nodes of one; return those."""
        name = text(given, "stationName") or text(given, "stationId") or part
        for each in ("stationHeight", "stationPosition"):
            if field(given, each) is not None:
                self._notes.without_effect(f"{part}.{each}", "robots go to the nodes of a station, on the floor")
        listed = field(given, "interactionNodeIds")
        keys = [str(key) for key in listed if isinstance(key, str | int)] if isinstance(listed, list) else []
        known = [key for key in keys if key in self.builder.graph.nodes]
        for key in keys:
            if key not in known:
                self._notes.refused(f"{part}.interactionNodeIds", f"no node has the id {key}")
        for at, key in enumerate(known):
            self._add_station(name if at == 0 else f"{name} {key}", key, part)
        if not keys:
            self._notes.refused(part, "it has no interactionNodeIds: no robot can be sent there")
        return set(known)

    def _add_station(self, name: str, key: str, part: str) -> None:
        uses = tuple(dict.fromkeys(self._uses.get(key, ())))
        place = self.builder.graph.nodes[key].place
        self.builder.graph.stations.append(GraphStation(name, place, self._yaws.get(key), uses, part))


def _control(point: Mapping[str, Any]) -> Iterator[float]:
    for name, default in (("x", math.nan), ("y", math.nan), ("weight", 1.0)):
        value = number(point, name)
        yield default if value is None else value


# -- curves: rational B-splines (NURBS) --------------------------------------------------------------------------------

OFF = 0.02
"""Distance between a curve and its positions [m]."""

MOST_CONTROL_POINTS = 1000
"""Largest number of control points of a curve."""

SAMPLES = 33
"""Number of places of a curve for each of its spans, of which few are kept."""


def _positions(knots: Sequence[float], points: Sequence[tuple[float, float, float]], degree: int) -> list[Place]:
    """Return positions on a curve, from its start to its end.

    Parameters
    ----------
    knots : sequence of float
        Ascending; as many as points, and one and the degree more.
    points : sequence of (x, y, weight)
    degree : int

    Raises
    ------
    ValueError
        It is no curve; the text says why.
    """
    import shapely  # noqa: PLC0415 - only curves need it
    from scipy.interpolate import BSpline  # noqa: PLC0415

    if not 1 <= degree < len(points) <= MOST_CONTROL_POINTS:
        raise ValueError(f"degree {degree} with {len(points)} control points is no curve")
    if len(knots) != len(points) + degree + 1:
        raise ValueError(f"{len(points)} control points of degree {degree} need {len(points) + degree + 1} knots")
    steps = np.diff(knots)
    if (steps < 0.0).any() or knots[degree] >= knots[len(points)]:
        raise ValueError("the knots must ascend")
    weighted = np.array(points, float)
    if (weighted[:, 2] <= 0.0).any():
        raise ValueError("weights must be above 0")
    weighted[:, :2] *= weighted[:, 2:]
    spans = np.unique(np.asarray(knots[degree : len(points) + 1], float))
    at = np.unique(np.concatenate([np.linspace(low, high, SAMPLES) for low, high in pairwise(spans)]))
    found = BSpline(np.asarray(knots, float), weighted, degree)(at)
    curve = shapely.simplify(shapely.LineString(found[:, :2] / found[:, 2:]), OFF)
    return [(float(x), float(y)) for x, y in curve.coords]
