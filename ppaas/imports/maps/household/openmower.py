"""Maps of OpenMower, the software of lawn mowers: areas to mow, ways between them, and obstacles, as polygons.

Three forms are read: ``map.json`` of OpenMower, backups of its web interface, and GeoJSON of OpenMowerNext, whose
positions are degrees. Everything outside the areas is occupied, as in OpenMower itself.

Sources: ``mower_map_service.cpp`` of ClemensElflein/open_mower_ros, the messages of ``mower_map``, and the documents of
jkaflik/OpenMowerNext.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ppaas.errors import InvalidMap
from ppaas.imports.maps.common.imported_map import (
    ImportedMap,
    KeepOutZones,
    MapOptions,
    grid_around,
    grid_of,
    report_cells,
)
from ppaas.imports.maps.household.areas import Ring, fill_area
from ppaas.imports.maps.household.json_content import decoded_json
from ppaas.imports.report import ImportReport
from ppaas.maps.georeference import GeoAnchor

RESOLUTION = 0.05
"""Edge of a cell, as OpenMower draws its map [m]."""

MARGIN = 1.0
"""Occupied border around the areas [m]."""

TOLERANCE = 0.02
"""How far the outline of a keep-out zone may be from that of the file [m]."""

FARTHEST = 10_000.0
"""Largest coordinate [m]."""

FREE_KINDS = ("mow", "nav", "operation", "navigation")
BLOCKED_KINDS = ("obstacle", "exclusion")


@dataclass(frozen=True, slots=True)
class _Area:
    part: str
    name: str
    kind: str
    active: bool
    ring: Ring | None


def is_openmower(tree: Any) -> bool:
    """Return whether decoded JSON is a map of OpenMower, in any of its forms."""
    return isinstance(tree, dict) and (_is_native(tree) or _is_backup(tree) or _is_geojson(tree))


def _is_native(tree: dict[str, Any]) -> bool:
    return isinstance(tree.get("areas"), list)


def _is_backup(tree: dict[str, Any]) -> bool:
    return isinstance(_of(tree, "WorkingArea"), list) or isinstance(_of(tree, "NavigationAreas"), list)


def _is_geojson(tree: dict[str, Any]) -> bool:
    features = tree.get("features")
    kinds = [_of(_of(each, "properties"), "type") for each in features] if isinstance(features, list) else []
    return any(kind in (*FREE_KINDS, *BLOCKED_KINDS, "docking_station") for kind in kinds)


def import_openmower(
    content: bytes, name: str, options: MapOptions | None = None, tree: Any = None
) -> tuple[ImportedMap, ImportReport]:
    """Import a map of OpenMower.

    Parameters
    ----------
    content : bytes
    name : str
        Name of the file, for the report.
    options : MapOptions, optional
    tree : any, optional
        The decoded JSON, if it is decoded already.

    Raises
    ------
    InvalidMap
        It is not a map of OpenMower, no area is free, or the map would have too many cells.
    """
    options = options or MapOptions()
    tree = decoded_json(content) if tree is None else tree
    if not is_openmower(tree):
        raise InvalidMap("the file is not a map of OpenMower: it needs 'areas', 'WorkingArea' or features with types")
    report = ImportReport(name)
    anchor = None
    if _is_native(tree):
        areas = list(_native(tree))
        _docks(tree.get("docking_stations"), report)
    elif _is_backup(tree):
        areas = list(_backup(tree))
        _dock_of_backup(tree, report)
    else:
        anchor = _anchor(tree["features"], options.anchor)
        areas = list(_features(tree["features"], anchor, report))
        report.translated("positions", f"degrees to metres from {anchor.latitude:.7f}, {anchor.longitude:.7f}")
    drawn = _draw(areas, options.resolution or RESOLUTION, report)
    return drawn.anchored(anchor).anchored(options.anchor), report


def _of(tree: Any, key: str) -> Any:
    """Return a value of a dict by a key in any case; None without one."""
    if not isinstance(tree, dict):
        return None
    if key in tree:
        return tree[key]
    return next((value for name, value in tree.items() if name.lower() == key.lower()), None)


# -- areas of each form ------------------------------------------------------------------------------------------------


def _native(tree: dict[str, Any]) -> Iterator[_Area]:
    for number, area in enumerate(tree["areas"]):
        properties = _of(area, "properties")
        kind = str(_of(properties, "type") or "draft")
        title = str(_of(properties, "name") or f"{kind} {number}")
        active = _of(properties, "active") is not False
        yield _Area(f"areas[{number}] {kind} {title!r:.40}", title, kind, active, _ring(_of(area, "outline")))


def _backup(tree: dict[str, Any]) -> Iterator[_Area]:
    for key, kind in (("WorkingArea", "mow"), ("NavigationAreas", "nav")):
        for number, area in enumerate(_of(tree, key) or ()):
            part, title = f"{key}[{number}]", str(_of(area, "Name") or f"{kind} {number}")
            yield _Area(part, title, kind, True, _ring(_of(_of(area, "Area"), "Points")))
            for count, obstacle in enumerate(_of(area, "Obstacles") or ()):
                ring = _ring(_of(obstacle, "Points"))
                yield _Area(f"{part}.Obstacles[{count}]", f"obstacle of {title}", "obstacle", True, ring)


def _features(features: list[Any], anchor: GeoAnchor, report: ImportReport) -> Iterator[_Area]:
    for number, feature in enumerate(features):
        properties, geometry = _of(feature, "properties"), _of(feature, "geometry")
        kind, coordinates = str(_of(properties, "type")), _of(geometry, "coordinates")
        title = str(_of(properties, "name") or f"{kind} {number}")
        part = f"features[{number}] {kind} {title!r:.40}"
        if kind == "docking_station":
            report.without_effect(part, "a map has no docks")
            continue
        outer = coordinates[0] if isinstance(coordinates, list) and coordinates else None
        degrees = _ring([{"x": place[0], "y": place[1]} for place in outer or () if _is_position(place)], 180.0)
        ring = None if degrees is None else np.array([anchor.to_map(y, x) for x, y in degrees.tolist()])
        yield _Area(part, title, kind, True, ring)


def _is_position(place: Any) -> bool:
    return isinstance(place, list) and len(place) >= 2


def _ring(points: Any, farthest: float = FARTHEST) -> Ring | None:
    """Return the corners of an outline; None if they are not valid."""
    if not isinstance(points, list) or len(points) < 3:
        return None
    try:
        ring = np.array([_of(each, name) for each in points for name in "xy"], np.float64).reshape(-1, 2)
    except (TypeError, ValueError):
        return None
    return ring if np.isfinite(ring).all() and np.abs(ring).max() <= farthest else None


def _anchor(features: list[Any], given: GeoAnchor | None) -> GeoAnchor:
    """Return the georeference for positions in degrees: the one given, or else the south-western corner of all."""
    if given is not None:
        return given
    places = [place[:2] for each in features for place in _positions(_of(_of(each, "geometry"), "coordinates"))]
    if not places:
        raise InvalidMap("the features have no positions")
    longitude, latitude = np.min(np.array(places, np.float64), axis=0).tolist()
    return GeoAnchor(round(latitude, 6), round(longitude, 6))


def _positions(coordinates: Any, depth: int = 4) -> Iterator[list[float]]:
    if not isinstance(coordinates, list) or depth <= 0:
        return
    if len(coordinates) >= 2 and all(isinstance(each, int | float) and math.isfinite(each) for each in coordinates[:2]):
        yield coordinates
        return
    for each in coordinates:
        yield from _positions(each, depth - 1)


# -- the map of areas --------------------------------------------------------------------------------------------------


def _draw(areas: list[_Area], resolution: float, report: ImportReport) -> ImportedMap:
    """Return the map; in cells of several areas the last one of the file counts."""
    used = [area for area in areas if _is_used(area, report)]
    if not any(area.kind in FREE_KINDS for area in used):
        raise InvalidMap("the map has no area in which a robot may drive")
    corners = np.concatenate([area.ring for area in used if area.ring is not None])
    info = grid_around(corners.min(axis=0) - MARGIN, corners.max(axis=0) + MARGIN, resolution)
    free, zones = np.zeros(info.shape, np.bool_), KeepOutZones(report)
    for area in used:
        assert area.ring is not None
        fill_area(free, info, area.ring, area.kind in FREE_KINDS)
        if area.kind in FREE_KINDS:
            report.translated(area.part, "free cells")
        else:
            zones.add(area.part, area.name, _simplified(area.ring), ", and occupied cells")
    grid = grid_of(info, free, ~free)
    report_cells(report, grid)
    return ImportedMap(grid, zones=zones.zones())


def _is_used(area: _Area, report: ImportReport) -> bool:
    known = (*FREE_KINDS, *BLOCKED_KINDS)
    if not area.active:
        report.without_effect(area.part, "it is switched off in OpenMower")
    elif area.kind == "draft":
        report.without_effect(area.part, "it is a draft; give it a type in OpenMower")
    elif area.kind not in known:
        near = report.nearest_name(area.kind, known)
        report.refused(area.part, f"unknown type {area.kind!r}" + (f"; did you mean {near!r}?" if near else ""))
    elif area.ring is None:
        report.refused(area.part, f"its outline needs three points or more with x and y up to {FARTHEST:g} m")
    else:
        return True
    return False


def _simplified(ring: Ring) -> list[tuple[float, float]]:
    """Return an outline with fewer corners; drives with GPS have one each few centimetres."""
    import shapely  # noqa: PLC0415 - the other importers of JSON need it not

    line = shapely.LineString(np.concatenate((ring, ring[:1]))).simplify(TOLERANCE)
    corners = [(x, y) for x, y in np.asarray(line.coords).tolist()]
    return corners if len(corners) > 3 else [(x, y) for x, y in ring.tolist()]


def _docks(stations: Any, report: ImportReport) -> None:
    for number, station in enumerate(stations if isinstance(stations, list) else ()):
        place = _of(station, "position")
        _dock(f"docking_stations[{number}]", _of(place, "x"), _of(place, "y"), _of(station, "heading"), report)


def _dock_of_backup(tree: dict[str, Any], report: ImportReport) -> None:
    if _of(tree, "DockX") is not None:
        _dock("DockX", _of(tree, "DockX"), _of(tree, "DockY"), _of(tree, "DockHeading"), report)


def _dock(part: str, x: Any, y: Any, heading: Any, report: ImportReport) -> None:
    at = ", ".join(f"{name}={value:.2f}" for name, value in (("x", x), ("y", y), ("yaw", heading)) if _is_real(value))
    report.without_effect(part, f"a map has no docks: it is at {at}" if at else "a map has no docks")


def _is_real(value: Any) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)
