"""Fitting: a graph whose lanes have room for robots of a size beside each other."""

import msgspec
import numpy as np

from ppaas.errors import InvalidInput
from ppaas.fleet.lane_drawing import JOINS, DrawnLane, LaneConflict, network_of
from ppaas.fleet.lane_placing import placed_on
from ppaas.fleet.lane_roadmap import check_apart
from ppaas.fleet.robot_sizes import RobotSizes
from ppaas.imports.graphs.model.gathered import GatheredNotes
from ppaas.imports.graphs.model.route_graph import GraphEdge, RouteGraph, points_of
from ppaas.imports.report import ImportReport
from ppaas.traffic.settings import TrafficParameters
from ppaas.zones.zone import MOST_ON_LANES

MOST_LEFT_OUT = 60
"""Largest number of edges that are left out one after the other."""


def fitted(graph: RouteGraph, radius: float, report: ImportReport) -> RouteGraph:
    """Return a graph along which robots of a radius have room in the traffic.

    Nodes that are nearer to each other than two such robots may be become one, at the place of the first. Then edges
    that are too near to others are left out, one after the other, the shortest first.

    Parameters
    ----------
    graph : RouteGraph
    radius : float
        Radius of the largest robots [m].
    report : ImportReport
        Takes what was joined and left out.
    """
    width = RobotSizes(radius, TrafficParameters().margin).spacing
    notes = GatheredNotes()
    found = _joined(graph, width, notes)
    if sum(len(points_of(found, edge)) for edge in found.edges) <= 2 * MOST_ON_LANES:
        try:
            found = _without_conflicts(found, width, notes)
        except InvalidInput as error:
            notes.without_effect("--radius", str(error))
    else:
        notes.without_effect("--radius", "the graph is too large to be fitted; ppaas fleet lanes checks lanes")
    notes.write(report)
    return found


USUAL_RADIUS = 0.2
"""Radius of robots for which room on the lanes is checked if nobody says how large they are [m]."""


def report_room(graph: RouteGraph, report: ImportReport) -> None:
    """Report where robots of a usual size have no room, since such lanes stop the robots of the traffic."""
    if sum(len(points_of(graph, edge)) for edge in graph.edges) > 2 * MOST_ON_LANES:
        return
    try:
        conflict = _conflict(graph, RobotSizes(USUAL_RADIUS, TrafficParameters().margin).spacing)
    except InvalidInput as error:
        report.taken("lanes", f"robots cannot use them: {error}")
        return
    if conflict is not None:
        report.taken(
            "lanes",
            f"robots with a radius of {USUAL_RADIUS:g} m have no room: {_reason(str(conflict), graph, graph.edges)}; "
            "--radius M joins nodes and leaves edges out for the robots that you have",
        )


def _joined(graph: RouteGraph, width: float, notes: GatheredNotes) -> RouteGraph:
    """Return a graph without nodes that are nearer to another one than a width [m]."""
    from scipy.spatial import cKDTree  # noqa: PLC0415 - only imports of graphs need it

    keys = list(graph.nodes)
    if not keys:
        return graph
    places = np.array([graph.nodes[key].place for key in keys])
    degrees = _degrees(graph)
    near = cKDTree(places).query_ball_point(places, width * (1.0 - 1e-6))
    kept: dict[int, int] = {}
    for at in sorted(range(len(keys)), key=lambda at: (-degrees.get(keys[at], 0), at)):
        if at not in kept:
            kept |= {other: at for other in near[at] if other not in kept}
            kept[at] = at
    gone = {keys[at]: keys[to] for at, to in kept.items() if at != to}
    for key in gone:
        if degrees.get(key):
            notes.translated(
                graph.nodes[key].part or f"node {graph.nodes[key].name}",
                f"joined with a node nearby: robots of this radius need {width:.2f} m between two nodes",
            )
    edges = [
        msgspec.structs.replace(edge, start=gone.get(edge.start, edge.start), end=gone.get(edge.end, edge.end))
        for edge in graph.edges
    ]
    kept_edges = [edge for edge in edges if edge.start != edge.end]
    nodes = {key: node for key, node in graph.nodes.items() if key not in gone}
    return RouteGraph(nodes, kept_edges, graph.stations, graph.passing, graph.marks)


def _degrees(graph: RouteGraph) -> dict[str, int]:
    near: dict[str, set[str]] = {}
    for edge in graph.edges:
        near.setdefault(edge.start, set()).add(edge.end)
        near.setdefault(edge.end, set()).add(edge.start)
    return {key: len(others) for key, others in near.items()}


def _without_conflicts(graph: RouteGraph, width: float, notes: GatheredNotes) -> RouteGraph:
    edges = list(graph.edges)
    for _ in range(MOST_LEFT_OUT):
        found = RouteGraph(graph.nodes, edges, graph.stations, graph.passing, graph.marks)
        conflict = _conflict(found, width)
        if conflict is None:
            return found
        lengths = {name: _length(found, edges[int(name)]) for name in conflict.lanes}
        shortest = edges[int(min(lengths, key=lambda name: lengths[name]))]
        ends = {shortest.start, shortest.end}
        reason = _reason(str(conflict), found, edges)
        for edge in edges:
            if {edge.start, edge.end} == ends:
                notes.refused(edge.part or edge.name, f"left out: {reason}")
        edges = [edge for edge in edges if {edge.start, edge.end} != ends]
    notes.without_effect("--radius", "more lanes are too near to each other; ppaas fleet lanes names them")
    return RouteGraph(graph.nodes, edges, graph.stations, graph.passing, graph.marks)


def _conflict(graph: RouteGraph, width: float) -> LaneConflict | None:
    """Return the first conflict of edges, which it names by their numbers; None if robots have room."""
    lines = [
        DrawnLane(str(at), np.array(points_of(graph, edge)), one_way=True)
        for at, edge in enumerate(graph.edges)
        if _length(graph, edge) > JOINS
    ]
    if not lines:
        return None
    try:
        check_apart(placed_on(network_of(lines), width), width)
    except LaneConflict as error:
        return error
    return None


def _reason(text: str, graph: RouteGraph, edges: list[GraphEdge]) -> str:
    for at, edge in enumerate(edges):
        start, end = graph.nodes[edge.start].name, graph.nodes[edge.end].name
        text = text.replace(f"'{at}'", repr(f"{start} - {end}" if start and end else edge.name))
    return text


def _length(graph: RouteGraph, edge: GraphEdge) -> float:
    points = np.array(points_of(graph, edge))
    return float(np.hypot(*np.diff(points, axis=0).T).sum())
