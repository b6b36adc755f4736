"""Buildings of Open-RMF (``.building.yaml`` of its traffic editor): the lanes and named vertices of one floor."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ppaas.imports.graphs.model.cleaning import is_place
from ppaas.imports.graphs.model.gathered import GatheredNotes
from ppaas.imports.graphs.model.route_graph import GraphMark, GraphOptions, Place, ReadGraph, RouteGraph, points_of
from ppaas.imports.graphs.rmf.fields import RmfReader, index_of, items, levels_of
from ppaas.imports.graphs.rmf.levels import RmfBuilding, places_of, raw_place, value_of
from ppaas.imports.graphs.rmf.lifts import RmfLift, lifts_of
from ppaas.imports.graphs.rmf.nav_graph import chosen_level
from ppaas.imports.report import ImportReport

_PARTS: Mapping[str, str] = {
    "walls": "the grid of the map has the walls",
    "floors": "the grid of the map has the floor",
    "drawing": "the grid of the map has the drawing",
    "models": "furniture is in the grid of the map, or seen by sensors",
    "human_lanes": "lanes of simulated people are not imported",
    "layers": "layers are not imported",
    "features": "features that align layers are not needed",
    "constraints": "constraints that align layers are not needed",
    "holes": "holes of the floor are not imported; draw a keep-out zone",
    "zones": "zones of Open-RMF have no effect",
}
"""Parts of a floor that have no effect, and why."""


def building_graph_of(tree: Mapping[str, Any], report: ImportReport, options: GraphOptions) -> ReadGraph:
    """Return the graph of one floor of a decoded building, with its doors, docks and landings of lifts.

    Raises
    ------
    InvalidInput
        It has no floors, or not the one that was asked for, or its scale is not known.
    """
    building = rmf_building_of(tree, report)
    name = chosen_level(building.levels, options.level, building.reference, report)
    graph = floor_graph_of(building, name, lifts_of(building, report, options), report, options)
    for part, reason in WITHOUT_EFFECT.items():
        if tree.get(part):
            report.without_effect(part, reason)
    return ReadGraph(graph, report)


WITHOUT_EFFECT: Mapping[str, str] = {"crowd_sim": "no people are simulated"}
"""Parts of a building that have no effect, and why."""


def rmf_building_of(tree: Mapping[str, Any], report: ImportReport) -> RmfBuilding:
    """Return a decoded building; ``InvalidInput`` if it has no floors."""
    levels = levels_of(tree, report.source)
    named = str(tree.get("reference_level_name"))
    return RmfBuilding(tree, levels, named if named in levels else next(iter(levels)))


def floor_graph_of(
    building: RmfBuilding, name: str, lifts: Sequence[RmfLift], report: ImportReport, options: GraphOptions
) -> RouteGraph:
    """Return the graph of a floor, in the frame of the building."""
    level, notes = building.levels[name], GatheredNotes()
    lanes = _chosen_lanes(level, name, report, options)
    raw = [raw_place(each) for each in items(level, "vertices")]
    known = [at for at, place in enumerate(raw) if place is not None]
    places = dict(
        zip(known, places_of(building, name, [raw[at] or (0.0, 0.0) for at in known], report, options), strict=True)
    )
    reader = RmfReader(notes, f"levels.{name}")
    ends = {index_of(end) for _, lane in lanes for end in lane[:2]}
    for at, vertex in enumerate(items(level, "vertices")):
        part, called = f"levels.{name}.vertices[{at}]", _name_of(vertex)
        if at not in places:
            notes.refused(part, "a vertex is [x, y, z, name, {…}]")
        elif str(at) in ends:
            reader.add_vertex(at, places[at], called, _properties(vertex, 4))
        elif called:
            notes.without_effect(f"{part} {called}", "on no lane of this graph")
    for at, lane in lanes:
        properties = _properties(lane, 2)
        both_ways = properties.pop("bidirectional", False) is True
        reader.add_lane(at, (index_of(lane[0]), index_of(lane[1])), properties, both_ways=both_ways)
    reader.add_docks()
    graph = reader.builder.graph
    graph.marks += _doors(level, places, graph, f"levels.{name}", report)
    graph.marks += [mark for lift in lifts for mark in lift.marks(name)]
    for part, reason in _PARTS.items():
        if level.get(part):
            report.without_effect(f"levels.{name}.{part}", reason)
    report.taken(f"levels.{name}", f"{len(graph.nodes)} vertices on lanes")
    notes.write(report)
    return graph


def _chosen_lanes(
    level: Mapping[str, Any], name: str, report: ImportReport, options: GraphOptions
) -> list[tuple[int, list[Any]]]:
    """Return the lanes of one graph, each with its number; report the other graphs and what is no lane."""
    by_graph: dict[int, list[tuple[int, list[Any]]]] = {}
    for at, lane in enumerate(items(level, "lanes")):
        if not isinstance(lane, list) or len(lane) < 2:
            report.refused(f"levels.{name}.lanes[{at}]", "a lane is [from, to, {…}]")
            continue
        index = _properties(lane, 2).get("graph_idx", 0)
        by_graph.setdefault(index if isinstance(index, int) else 0, []).append((at, lane))
    chosen = options.graph if options.graph is not None else min(by_graph, default=0)
    for index in sorted(by_graph.keys() - {chosen}):
        report.without_effect(
            f"graph {index}", f"{len(by_graph[index])} lanes of another fleet; import them with --graph {index}"
        )
    return by_graph.get(chosen, [])


def _name_of(vertex: Any) -> str:
    return str(vertex[3]) if isinstance(vertex, list) and len(vertex) > 3 and vertex[3] else ""


def _properties(given: list[Any], at: int) -> dict[str, Any]:
    found = given[at] if len(given) > at else None
    return {str(key): value_of(value) for key, value in found.items()} if isinstance(found, dict) else {}


def _doors(
    level: Mapping[str, Any], places: Mapping[int, Place], graph: RouteGraph, part: str, report: ImportReport
) -> list[GraphMark]:
    """Return the doors of a floor, and report which lanes lead through each."""
    import shapely  # noqa: PLC0415 - only imports of graphs need it

    lanes = [(edge.part, ends) for edge in graph.edges if all(map(is_place, ends := points_of(graph, edge)))]
    lines = shapely.linestrings(np.array([points for _, points in lanes])) if lanes else np.empty(0, object)
    found: list[GraphMark] = []
    for at, door in enumerate(items(level, "doors")):
        if not isinstance(door, list) or len(door) < 2 or not all(isinstance(end, int) for end in door[:2]):
            report.refused(f"{part}.doors[{at}]", "a door is [from, to, {…}]")
            continue
        name = str(_properties(door, 2).get("name") or f"door {at}")
        where = f"{part}.doors[{at}] {name}"
        one, other = (places.get(end) for end in door[:2])
        if one is None or other is None or not (is_place(one) and is_place(other)) or one == other:
            report.refused(where, "its ends are not two vertices of the floor")
            continue
        crossed: list[str] = []
        if len(lines):
            leaf = shapely.LineString([one, other])
            crossed = sorted({lanes[number][0] for number in np.nonzero(shapely.intersects(lines, leaf))[0]})
        through = f"lanes lead through it: {', '.join(crossed)}" if crossed else "no lane leads through it"
        report.translated(where, f"a door; {through}")
        found.append(GraphMark(name, "door", (one, other), part=where))
    return found
