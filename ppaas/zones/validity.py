"""Geometries of zones by the rules of GeoJSON and of OGC's simple features: what is mended, and what is wrong where.

The checks are GEOS's. A crossed outline has no one meaning: readers of polygons disagree on which of its parts
are inside. So it is never mended, and the place of the crossing is reported.
"""

import math
import re
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ppaas.zones.faults import Faults, Notes, place_text
from ppaas.zones.reading import EMPTY_PARTS
from ppaas.zones.shapes import (
    Geometry,
    MultiPolygon,
    Point,
    Polygon,
    Position,
    Ring,
    lines_of,
    polygons_of,
)

if TYPE_CHECKING:
    import shapely

SMALLEST_AREA, SHORTEST = 1e-4, 0.01
"""Least area of a polygon [m²], and least length of a line [m]; degrees taken for metres are smaller."""

SAME_PLACE = 1e-3
"""Distance up to which the last position of an outline is meant to be its first [m]."""

_REASON = re.compile(r"^(?P<what>[^\[]+)\[(?P<x>\S+) (?P<y>\S+)\]")
"""Reason why a geometry is not valid, in the words of GEOS."""

_CLOSED = "the outline was closed: its last position must be its first"
_TURNED = "the outline was reversed: RFC 7946 has outlines counterclockwise and holes clockwise"
_JOINED = "parts that overlap or touch were joined"
_SLIVERS = "parts and holes that enclose less than 1 cm² were left out"

_DEGREES = "are its positions longitudes and latitudes? They must be x, y in metres in the frame of the map"


class GeometryFault(NamedTuple):
    """What is wrong with a geometry, and where [m]."""

    text: str
    place: tuple[float, float]


def mended(name: str, geometry: Geometry, faults: Faults, notes: Notes) -> Geometry:
    """Return the valid geometry of a zone: with closed, simple outlines that are oriented as RFC 7946 demands.

    Parameters
    ----------
    name : str
        Name of the zone.
    geometry : Geometry
        With enough positions, all of them finite (`check_geometry`) and in the plane.
    faults : Faults
        Takes what is wrong; the geometry is not valid then.
    notes : Notes
        Takes what was mended.
    """
    found: Sequence[GeometryFault]
    result: Geometry
    if isinstance(geometry, Point):
        return geometry
    if lines := lines_of(geometry):
        found, result = _faults_of_lines(lines), geometry
    else:
        given = polygons_of(geometry)
        polygons = [[_closed(name, ring, notes) for ring in rings] for rings in given if rings]
        if len(polygons) < len(given):
            notes.add(EMPTY_PARTS, name)
        polygons = _without_slivers(name, polygons, notes)
        found = [fault for rings in polygons if (fault := _fault_of_polygon(rings)) is not None]
        result = MultiPolygon(polygons) if found else _joined(name, polygons, notes)
    for fault in found:
        faults.add(name, fault.text, fault.place)
    return result


def outline_fault(corners: Sequence[Sequence[float]]) -> str:
    """Return what is wrong with the outline of a polygon of (n, 2) corners [m], and where; empty if it is valid."""
    ring = [list(corner) for corner in corners]
    fault = _fault_of_polygon([[*ring, ring[0]]])
    return "" if fault is None else fault.text


def line_fault(places: Sequence[Sequence[float]]) -> str:
    """Return what is wrong with a line of (n, 2) places [m], and where; empty if it is valid."""
    faults = _faults_of_lines([[list(place) for place in places]])
    return faults[0].text if faults else ""


def _closed(name: str, ring: Ring, notes: Notes) -> Ring:
    """Return a closed ring; a last position that is the first but for rounding is replaced by it."""
    if ring[0] == ring[-1]:
        return ring
    notes.add(_CLOSED, name)
    rounded = len(ring) > 3 and math.dist(ring[0], ring[-1]) <= SAME_PLACE
    return [*(ring[:-1] if rounded else ring), ring[0]]


def _without_slivers(name: str, polygons: list[list[Ring]], notes: Notes) -> list[list[Ring]]:
    """Return polygons without small holes, and without small parts unless all are small, as overlays leave them."""
    parts = [rings for rings in polygons if not _is_sliver(rings[0])] or polygons
    kept = [[rings[0], *(hole for hole in rings[1:] if not _is_sliver(hole))] for rings in parts]
    if sum(map(len, kept)) < sum(map(len, polygons)):
        notes.add(_SLIVERS, name)
    return kept


def _is_sliver(ring: Ring) -> bool:
    import shapely  # noqa: PLC0415 - only clouds and bridges have it

    return bool(shapely.convex_hull(shapely.LineString(ring)).area < SMALLEST_AREA)


def _fault_of_polygon(rings: list[Ring]) -> GeometryFault | None:
    """Return the first fault of an outline and its holes, all closed; None if they are valid."""
    import shapely  # noqa: PLC0415 - only clouds and bridges have it

    for number, ring in enumerate(rings):
        if fault := _fault_of_ring(ring, "its outline" if number == 0 else "a hole"):
            return fault
    reason = _REASON.match(shapely.is_valid_reason(shapely.Polygon(rings[0], rings[1:])))
    if reason is None:
        return None
    place = float(reason["x"]), float(reason["y"])
    what = {
        "Hole lies outside shell": "a hole lies outside of its outline at {}: draw it as a zone, or leave it out",
        "Holes are nested": "a hole lies in another one at {}: leave it out",
        "Interior is disconnected": "holes divide its area at {}: draw a MultiPolygon",
    }.get(reason["what"], "a hole crosses the outline or another hole at {}: draw one outline without it")
    return GeometryFault(what.format(place_text(place)), place)


def _fault_of_ring(ring: Ring, what: str) -> GeometryFault | None:
    import shapely  # noqa: PLC0415 - only clouds and bridges have it

    polygon = shapely.Polygon(ring)
    if shapely.convex_hull(polygon).area < SMALLEST_AREA:
        return _too_small(ring[0], f"{what} encloses no area")
    reason = _REASON.match(shapely.is_valid_reason(polygon))
    if reason is None:
        return None if polygon.area >= SMALLEST_AREA else _too_small(ring[0], f"{what} encloses almost no area")
    place = float(reason["x"]), float(reason["y"])
    touches = reason["what"].startswith("Ring")
    how = (
        f"touches itself at {place_text(place)}: leave out a corner that leads back, or draw a MultiPolygon or a hole"
        if touches
        else f"crosses itself at {place_text(place)}: put its corners in their order around the area"
    )
    return GeometryFault(f"{what} {how}", place)


def _too_small(place: Position, what: str) -> GeometryFault:
    at = place[0], place[1]
    return GeometryFault(f"{what} at {place_text(at)}; {_DEGREES}", at)


def _joined(name: str, polygons: list[list[Ring]], notes: Notes) -> Geometry:
    """Return valid polygons as one geometry, whose parts are apart, with oriented rings."""
    import shapely  # noqa: PLC0415 - only clouds and bridges have it

    given: shapely.Geometry = shapely.MultiPolygon([(rings[0], rings[1:]) for rings in polygons])
    if not shapely.is_valid(given):
        notes.add(_JOINED, name)
        given = shapely.union_all([shapely.Polygon(rings[0], rings[1:]) for rings in polygons])
    elif any(_is_clockwise(ring) == (number == 0) for rings in polygons for number, ring in enumerate(rings)):
        notes.add(_TURNED, name)
    parts = [_oriented(part) for part in shapely.get_parts(given)]
    return Polygon(parts[0]) if len(parts) == 1 else MultiPolygon(parts)


def _is_clockwise(ring: Ring) -> bool:
    return sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in pairwise(ring)) < 0.0


def _oriented(part: "shapely.Polygon") -> list[Ring]:
    rings = [part.exterior, *part.interiors]
    found = [[[float(x), float(y)] for x, y in ring.coords] for ring in rings]
    return [ring[::-1] if _is_clockwise(ring) == (number == 0) else ring for number, ring in enumerate(found)]


def _faults_of_lines(lines: list[Ring]) -> list[GeometryFault]:
    if sum(math.dist(one, other) for line in lines for one, other in pairwise(line)) < SHORTEST:
        at = lines[0][0][0], lines[0][0][1]
        return [GeometryFault(f"its line is shorter than {SHORTEST:g} m at {place_text(at)}; {_DEGREES}", at)]
    return [fault for line in lines if (fault := _doubling(line)) is not None]


def _doubling(line: Ring) -> GeometryFault | None:
    """Return the place where a line first leads back on itself; None if it does not."""
    import shapely  # noqa: PLC0415 - only clouds and bridges have it

    places = np.array(line)
    ways = np.diff(places, axis=0)
    segments = shapely.linestrings(np.stack((places[:-1], places[1:]), axis=1))
    one, other = shapely.STRtree(segments).query(segments, predicate="intersects")
    one, other = one[one < other], other[one < other]
    opposed = (ways[one] * ways[other]).sum(axis=1) < 0.0
    one, other = one[opposed], other[opposed]
    shared = shapely.intersection(segments[one], segments[other])
    found = np.nonzero(shapely.length(shared) > SHORTEST)[0]
    if not len(found):
        return None
    first = found[np.argmin(other[found])]
    x, y = places[other[first]]
    place = float(x), float(y)
    text = (
        f"its line leads back on itself at {place_text(place)}: draw it once; a lane without one_way is for both ways"
    )
    return GeometryFault(text, place)
