"""Import of a building of Open-RMF: a map with zones for each floor, and the record that joins them.

The map of a floor is in metres of its drawing, x to the right and y up from the upper left corner. Its anchor is where
that corner is in the frame of the reference floor, by fiducials of the same names.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import PurePath
from typing import Any, NamedTuple

import msgspec

from ppaas.buildings.building import Anchor, Building, Floor, LiftSettings
from ppaas.buildings.checks import warnings_of
from ppaas.buildings.layout import layout_of
from ppaas.errors import InvalidInput, InvalidMap
from ppaas.imports.buildings.floor_grid import FloorShape, grid_of_walls, with_marks
from ppaas.imports.collection import uncollected
from ppaas.imports.graphs.connectivity import report_connections, report_crossings
from ppaas.imports.graphs.fitting import fitted, report_room
from ppaas.imports.graphs.model.cleaning import is_place, on_map, without_far_places
from ppaas.imports.graphs.model.route_graph import MAX_FILE, NO_OPTIONS, GraphOptions, Place, RouteGraph, moved
from ppaas.imports.graphs.model.unique_names import unique_name
from ppaas.imports.graphs.rmf.building import WITHOUT_EFFECT, floor_graph_of, rmf_building_of
from ppaas.imports.graphs.rmf.fields import items, load_yaml, number
from ppaas.imports.graphs.rmf.levels import IMAGE, RmfBuilding, Similarity, places_of, raw_place, similarity_of
from ppaas.imports.graphs.rmf.lifts import RmfLift, lifts_of
from ppaas.imports.graphs.to_zones import zones_of_graph
from ppaas.imports.maps.common.imported_map import ImportedMap, report_cells
from ppaas.imports.maps.drawings.plan_import import import_plan
from ppaas.imports.maps.drawings.plan_picture import RESOLUTION, PlanOptions, ScaleBar
from ppaas.imports.report import ImportReport
from ppaas.maps.grid import GridMap


@dataclass(frozen=True, slots=True)
class ImportedBuilding:
    """Building of another program.

    Parameters
    ----------
    building : Building
        Its floors name the maps by their ids.
    maps : dict of str to ImportedMap
        Maps with zones, by the name of the floor.
    warnings : tuple of str
        What its layout leaves out, or what may be wrong.
    """

    building: Building
    maps: Mapping[str, ImportedMap]
    warnings: tuple[str, ...]


class _Source(NamedTuple):
    building: RmfBuilding
    lifts: list[RmfLift]
    drawings: Mapping[str, bytes]
    resolution: float
    options: GraphOptions

    @property
    def is_drawn(self) -> bool:
        """Whether its positions are pixels of drawings."""
        return (self.building.tree.get("coordinate_system") or IMAGE) == IMAGE

    def similarity(self, level: str) -> Similarity:
        """Return the scale, rotation and shift of a floor; those of metres if it is not drawn."""
        if not self.is_drawn:
            return Similarity(1.0)
        return similarity_of(self.building, level, ImportReport(""), self.options)


def drawings_of(content: bytes, name: str) -> dict[str, str]:
    """Return the names of the files of the drawings of a building, by floor; its import may have their contents.

    Raises
    ------
    InvalidInput
        It cannot be read at all.
    """
    building = rmf_building_of(load_yaml(content, name), ImportReport(name))
    return {level: file for level, each in building.levels.items() if (file := _drawing(each))}


@uncollected()
def import_building(
    content: bytes,
    name: str,
    building_id: str,
    drawings: Mapping[str, bytes] | None = None,
    *,
    resolution: float = RESOLUTION,
    options: GraphOptions = NO_OPTIONS,
) -> tuple[ImportedBuilding, ImportReport]:
    """Import all floors of a building.

    Parameters
    ----------
    content : bytes
        ``.building.yaml``.
    name : str
        Name of the file, for people.
    building_id : str
        Id of the building, with which the ids of its maps begin.
    drawings : mapping of str to bytes, optional
        Contents of drawings by floor. The grid of a floor without one is made of its walls.
    resolution : float
        Edge of a cell [m].
    options : GraphOptions

    Raises
    ------
    InvalidInput
        The file cannot be read at all, or has no floor that can be a map; the text says why.
    """
    report = ImportReport(name)
    if len(content) > MAX_FILE:
        raise InvalidInput(f"{name} has {len(content)} bytes; at most {MAX_FILE} are allowed")
    building = rmf_building_of(load_yaml(content, name), report)
    lifts = lifts_of(building, report, options)
    source = _Source(building, lifts, drawings or {}, resolution, options)
    maps: dict[str, ImportedMap] = {}
    floors: list[Floor] = []
    for level in building.levels:
        found = _floor(source, level, report)
        if found is not None:
            floors.append(_record(source, level, building_id, floors))
            maps[floors[-1].name] = found
    for part, reason in WITHOUT_EFFECT.items():
        if building.tree.get(part):
            report.without_effect(part, reason)
    if not floors:
        raise InvalidInput(f"{name} has no floor with walls, lanes or a drawing")
    settings = tuple(LiftSettings(lift=lift.name) for lift in lifts if len(lift.stops) > 1)
    made = Building(floors=tuple(floors), lifts=settings)
    layout = layout_of(made, {level: imported.zones for level, imported in maps.items()})
    return ImportedBuilding(made, maps, warnings_of(layout)), report


# -- floors ------------------------------------------------------------------------------------------------------------


def _record(source: _Source, level: str, building_id: str, others: list[Floor]) -> Floor:
    """Return the record of a floor, with a name and a map that no other has."""
    name = unique_name(level, {floor.name for floor in others})
    found = unique_name(f"{building_id}-{level}", {floor.map for floor in others}, r"[^A-Za-z0-9_.-]+")
    elevation = number(source.building.levels[level].get("elevation"))
    return Floor(name=name, map=found, elevation=elevation or 0.0, anchor=_anchor(source.similarity(level)))


def _anchor(similarity: Similarity) -> Anchor:
    x, y = similarity.shift
    return round(x, 6) + 0.0, round(y, 6) + 0.0, round(similarity.rotation, 9) + 0.0  # no -0


def _floor(source: _Source, level: str, whole: ImportReport) -> ImportedMap | None:
    """Return the map of a floor with its zones; None if there is nothing on it."""
    report = ImportReport(whole.source)
    graph = floor_graph_of(source.building, level, source.lifts, report, source.options)
    graph = without_far_places(_on_floor(graph, source.similarity(level)), report)
    grid = _grid(source, level, graph, report)
    if grid is not None:
        grid = with_marks(grid, graph.marks)
        report_cells(report, grid)
        graph = on_map(graph, grid.info, report)
        if source.options.radius is None:
            report_room(graph, report)
        else:
            graph = fitted(graph, source.options.radius, report)
        report_connections(graph, report)
        report_crossings(graph, report)
    zones = zones_of_graph(graph, report)
    begin = f"levels.{level}"
    for entry in report.entries:
        part = entry.part if entry.part.startswith((begin, "levels.")) else f"{begin}: {entry.part}"
        whole.entries.append(msgspec.structs.replace(entry, part=part))
    if grid is None:
        whole.refused(begin, "it has neither walls nor lanes nor a drawing, so it is no floor")
        return None
    return ImportedMap(grid, zones=zones)


def _on_floor(graph: RouteGraph, similarity: Similarity) -> RouteGraph:
    """Return a graph in the frame of the building in the frame of the map of its floor."""
    return moved(graph, similarity.back())


def _grid(source: _Source, level: str, graph: RouteGraph, report: ImportReport) -> GridMap | None:
    drawing = _drawing(source.building.levels[level])
    part = f"levels.{level}.drawing"
    if source.is_drawn and level in source.drawings:
        try:
            return _drawn(source, level, PurePath(drawing).name, report)
        except (InvalidInput, InvalidMap) as error:
            report.refused(part, f"{error}; the grid is made of walls")
    elif drawing:
        report.without_effect(part, f"there is no file {drawing!r}: the grid is made of walls")
    shape = _shape(source, level, graph, report)
    return grid_of_walls(shape, source.resolution, report) if len(shape.corners()) else None


def _drawn(source: _Source, level: str, name: str, report: ImportReport) -> GridMap:
    """Return the grid of a drawing, whose upper left corner is the origin of the map."""
    pixel = ScaleBar((0.0, 0.0), (1.0, 0.0), source.similarity(level).scale)
    plan = PlanOptions(scale=pixel, resolution=source.resolution)
    imported, found, _ = import_plan(source.drawings[level], name, plan)
    report.entries += found.entries
    info = imported.grid.info
    origin = info.origin._replace(y=info.origin.y - info.height * info.resolution)
    return GridMap(imported.grid.data, replace(info, origin=origin))


def _drawing(level: Mapping[str, Any]) -> str:
    given = level.get("drawing")
    name = given.get("filename") if isinstance(given, dict) else None
    return name if isinstance(name, str) else ""


def _shape(source: _Source, level: str, graph: RouteGraph, report: ImportReport) -> FloorShape:
    """Return walls and areas of a floor in the frame of its map."""
    fields = source.building.levels[level]
    vertices = [raw_place(each) for each in items(fields, "vertices")]
    known = [at for at, place in enumerate(vertices) if place is not None]
    raw = [vertices[at] or (0.0, 0.0) for at in known]
    in_building = places_of(source.building, level, raw, ImportReport(""), source.options)
    back = source.similarity(level).back()
    shifted = Similarity(1.0, back[2], (back[0], back[1]))
    places = {at: shifted.place(*place) for at, place in zip(known, in_building, strict=True) if is_place(place)}
    shape = FloorShape(places=[node.place for node in graph.nodes.values()])
    for at, wall in enumerate(items(fields, "walls")):
        ends = [places.get(end) for end in wall[:2] if isinstance(end, int)] if isinstance(wall, list) else []
        if len(ends) != 2 or ends[0] is None or ends[1] is None:
            report.refused(f"levels.{level}.walls[{at}]", "a wall is [from, to, {…}]")
        else:
            shape.walls.append((ends[0], ends[1]))
    for part, rings in (("floors", shape.areas), ("holes", shape.holes)):
        for at, area in enumerate(items(fields, part)):
            ring = _ring(area, places)
            if ring is None:
                report.refused(f"levels.{level}.{part}[{at}]", "its vertices are not three or more of the floor")
            else:
                rings.append(ring)
    return shape


def _ring(area: Any, places: Mapping[int, Place]) -> list[Place] | None:
    given = area.get("vertices") if isinstance(area, dict) else None
    ring = [places.get(at) for at in given if isinstance(at, int)] if isinstance(given, list) else []
    found = [place for place in ring if place is not None]
    return found if len(found) == len(ring) >= 3 else None
