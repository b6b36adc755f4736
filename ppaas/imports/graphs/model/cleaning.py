"""Cleaning of a graph: what no map can have is left out, each with a reason."""

import math

import numpy as np

from ppaas.imports.graphs.model.gathered import GatheredNotes
from ppaas.imports.graphs.model.route_graph import GraphEdge, GraphNode, Place, RouteGraph, points_of
from ppaas.imports.report import ImportReport
from ppaas.maps.grid import GridInfo
from ppaas.zones.shapes import FARTHEST


def is_place(place: Place) -> bool:
    """Return whether x, y are finite, and not farther than a map may be."""
    return all(math.isfinite(each) and abs(each) <= FARTHEST for each in place)


def without_far_places(graph: RouteGraph, report: ImportReport) -> RouteGraph:
    """Return a graph without nodes that are not finite or too far away, and without their edges."""
    reason = f"farther than {FARTHEST / 1000:g} km from the origin of the map: give the offset with --shift"
    return _without(graph, {key for key, node in graph.nodes.items() if not is_place(node.place)}, reason, report)


def on_map(graph: RouteGraph, info: GridInfo, report: ImportReport) -> RouteGraph:
    """Return the part of a graph that is on a grid; the rest is refused in the report."""
    keys = list(graph.nodes)
    inside = _inside(info, [graph.nodes[key].place for key in keys])
    low, high = np.array(info.to_world([(-0.5, -0.5), (info.height - 0.5, info.width - 0.5)]))
    box = f"{low[0]:.6g} to {high[0]:.6g} m × {low[1]:.6g} to {high[1]:.6g} m"
    reason = f"outside of the map, which is at {box}: is it another map or frame? --shift X Y YAW moves the graph"
    found = _without(graph, {key for key, kept in zip(keys, inside, strict=True) if not kept}, reason, report)
    notes = GatheredNotes()
    edges = []
    for edge in found.edges:
        if edge.between and not all(_inside(info, points_of(found, edge))):
            notes.refused(edge.part, "a part of its curve is outside of the map")
        else:
            edges.append(edge)
    stations = []
    for station in found.stations:
        if _inside(info, [station.place])[0]:
            stations.append(station)
        else:
            notes.refused(station.part, reason)
    passing = [place for place in found.passing if _inside(info, [place])[0]]
    marks = []
    for mark in found.marks:
        if all(_inside(info, list(mark.places))):
            marks.append(mark)
        else:
            notes.refused(mark.part, reason)
    notes.write(report)
    return RouteGraph(found.nodes, edges, stations, passing, marks)


def _inside(info: GridInfo, places: list[Place]) -> list[bool]:
    if not places:
        return []
    cells = info.to_cells(np.array(places))
    inside: list[bool] = np.all((cells >= 0) & (cells < info.shape), axis=1).tolist()
    return inside


def _without(graph: RouteGraph, gone: set[str], reason: str, report: ImportReport) -> RouteGraph:
    if not gone:
        return graph
    notes = GatheredNotes()
    for key in graph.nodes:
        if key in gone:
            notes.refused(graph.nodes[key].part, reason)
    for edge in graph.edges:
        if edge.start in gone or edge.end in gone:
            notes.refused(edge.part, "its node was refused")
    notes.write(report)
    return RouteGraph(
        {key: node for key, node in graph.nodes.items() if key not in gone},
        [edge for edge in graph.edges if edge.start not in gone and edge.end not in gone],
        [station for station in graph.stations if is_place(station.place)],
        [place for place in graph.passing if is_place(place)],
        [mark for mark in graph.marks if all(map(is_place, mark.places))],
    )


class GraphBuilder:
    """Graph that is read from a file, whose nodes have unique keys and whose edges have nodes.

    Parameters
    ----------
    notes : GatheredNotes
        Takes what is wrong.
    """

    def __init__(self, notes: GatheredNotes) -> None:
        self.graph = RouteGraph({}, [], [], [], [])
        self._notes = notes
        self._edges: set[str] = set()

    def add_node(self, key: str, node: GraphNode) -> bool:
        """Add a node, unless its key is taken; return whether it was added."""
        if key in self.graph.nodes:
            first = self.graph.nodes[key].part
            self._notes.refused(node.part, f"its id is that of {first}: the first one counts; give it another id")
            return False
        self.graph.nodes[key] = node
        return True

    def add_edge(self, edge: GraphEdge, key: str | None = None) -> bool:
        """Add an edge, unless a node is missing; return whether it was added. One whose id is taken is added."""
        for name in (edge.start, edge.end):
            if name not in self.graph.nodes:
                self._notes.refused(edge.part, f"no node has the id {name}")
                return False
        if edge.start == edge.end:
            self._notes.refused(edge.part, "it leads from a node to itself")
            return False
        if key is not None and key in self._edges:
            self._notes.translated(edge.part, f"id {key} is that of another edge, too; both were taken")
        self._edges.add(key or "")
        self.graph.edges.append(edge)
        return True
