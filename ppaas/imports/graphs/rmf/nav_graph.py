"""Navigation graphs of Open-RMF (``0.yaml``), as ``building_map_generator nav`` writes them: in metres already."""

from collections.abc import Mapping
from typing import Any

from ppaas.errors import InvalidInput
from ppaas.imports.graphs.model.gathered import GatheredNotes
from ppaas.imports.graphs.model.route_graph import GraphMark, GraphOptions, ReadGraph
from ppaas.imports.graphs.rmf.fields import RmfReader, index_of, items, levels_of, number
from ppaas.imports.report import ImportReport


def is_nav_graph(tree: Mapping[str, Any]) -> bool:
    """Return whether decoded YAML is a navigation graph: vertices of its floors have two numbers and properties."""
    levels = tree.get("levels")
    floors = levels.values() if isinstance(levels, dict) else ()
    vertices = [
        each["vertices"] for each in floors if isinstance(each, dict) and isinstance(each.get("vertices"), list)
    ]
    first = next((vertex for each in vertices for vertex in each), None)
    return isinstance(first, list) and (len(first) == 2 or (len(first) > 2 and isinstance(first[2], dict | str)))


def nav_graph_of(tree: Mapping[str, Any], report: ImportReport, options: GraphOptions) -> ReadGraph:
    """Return the graph of decoded YAML.

    Raises
    ------
    InvalidInput
        It has no floors, or not the one that was asked for.
    """
    levels = levels_of(tree, report.source)
    name = chosen_level(levels, options.level, next(iter(levels)), report)
    level, notes = levels[name], GatheredNotes()
    reader = RmfReader(notes, f"levels.{name}")
    for at, vertex in enumerate(items(level, "vertices")):
        place = _place(vertex)
        given = vertex[2] if place is not None and len(vertex) > 2 else None
        properties = given if isinstance(given, dict) else {"name": given if isinstance(given, str) else ""}
        if place is None:
            notes.refused(f"levels.{name}.vertices[{at}]", "a vertex is [x, y, {…}]")
            continue
        reader.add_vertex(at, place, str(properties.get("name") or ""), properties)
    for at, lane in enumerate(items(level, "lanes")):
        if not isinstance(lane, list) or len(lane) < 2:
            notes.refused(f"levels.{name}.lanes[{at}]", "a lane is [from, to, {…}]")
            continue
        properties = lane[2] if len(lane) > 2 and isinstance(lane[2], dict) else {}
        both_ways = properties.get("is_bidirectional") is True
        reader.add_lane(at, (index_of(lane[0]), index_of(lane[1])), properties, both_ways=both_ways)
    reader.add_docks()
    reader.builder.graph.marks += _doors(tree, name, report)
    for part, reason in (
        ("lifts", "it has no landing doors of lifts: import the building, or draw them"),
        ("zones", "zones of Open-RMF have no effect"),
        ("crs_name", "positions are taken as metres in the frame of the map"),
        ("offset", "it was not subtracted from the positions, as in Open-RMF; --shift X Y YAW moves them"),
    ):
        if tree.get(part):
            report.without_effect(part, reason)
    report.taken(f"levels.{name}", f"{len(reader.builder.graph.nodes)} vertices")
    notes.write(report)
    return ReadGraph(reader.builder.graph, report)


def chosen_level(
    levels: Mapping[str, Mapping[str, Any]], wanted: str | None, reference: str, report: ImportReport
) -> str:
    """Return the name of the floor to import: the one that is wanted, or the reference, or the first with lanes."""
    if wanted is not None and wanted not in levels:
        raise InvalidInput(f"{report.source} has no level {wanted!r}: it has {', '.join(levels)}")
    with_lanes = [name for name, level in levels.items() if level.get("lanes")]
    chosen = wanted or (reference if reference in with_lanes or not with_lanes else with_lanes[0])
    for name in levels:
        if name != chosen:
            empty = "" if name in with_lanes else ", without lanes"
            report.without_effect(f"levels.{name}", f"another floor{empty}; import it with --level {name}")
    return chosen


def _doors(tree: Mapping[str, Any], level: str, report: ImportReport) -> list[GraphMark]:
    """Return the doors of a floor, which site editors write: ``{NAME: {endpoints: [[x, y], [x, y]], map: LEVEL}}``."""
    doors = tree.get("doors")
    found = []
    for name, given in doors.items() if isinstance(doors, dict) else ():
        door = given if isinstance(given, dict) else {}
        if str(door.get("map", level)) != level:
            continue
        ends = door.get("endpoints")
        places = [_place(each) for each in ends] if isinstance(ends, list) else []
        if len(places) != 2 or places[0] is None or places[1] is None or places[0] == places[1]:
            report.refused(f"doors.{name}", "a door has two endpoints, each [x, y]")
            continue
        report.translated(f"doors.{name}", "a door")
        found.append(GraphMark(str(name), "door", (places[0], places[1]), part=f"doors.{name}"))
    return found


def _place(vertex: Any) -> tuple[float, float] | None:
    if not isinstance(vertex, list) or len(vertex) < 2:
        return None
    x, y = number(vertex[0]), number(vertex[1])
    return None if x is None or y is None else (x, y)
