"""Shapes of zones in GeoJSON (RFC 7946), with coordinates in metres in the frame of the map."""

import math
from itertools import pairwise
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidZones, ZoneFault
from ppaas.polygons import Points, distances_to_edges, within_polygon

AT_ONCE = 1 << 20
"""Number of pairs of points and edges that are considered at once."""

FARTHEST = 100_000.0
"""Largest coordinate [m]."""

Position = list[float]
"""x, y [m]; further numbers, such as a height, are ignored."""

Ring = list[Position]


class Polygon(msgspec.Struct, frozen=True, tag="Polygon"):
    """Area within the first ring and outside of the others; the last position of a ring is its first."""

    coordinates: list[Ring]


class MultiPolygon(msgspec.Struct, frozen=True, tag="MultiPolygon"):
    """Several polygons."""

    coordinates: list[list[Ring]]


class LineString(msgspec.Struct, frozen=True, tag="LineString"):
    """Line along which a lane leads."""

    coordinates: Ring


class MultiLineString(msgspec.Struct, frozen=True, tag="MultiLineString"):
    """Several lines."""

    coordinates: list[Ring]


class Point(msgspec.Struct, frozen=True, tag="Point"):
    """Place of a station."""

    coordinates: Position


Geometry = Polygon | MultiPolygon | LineString | MultiLineString | Point


class Area:
    """Area of a zone.

    Parameters
    ----------
    geometry : Geometry
    width : float
        Width of lanes along lines [m]; not used for polygons.
    """

    def __init__(self, geometry: Geometry, width: float = 0.0) -> None:
        polygons = [[_points(ring) for ring in polygon] for polygon in polygons_of(geometry)]
        self.polygons = [polygon for polygon in polygons if polygon]
        self.rings = [ring for polygon in self.polygons for ring in polygon]
        self.lines = [_points(line) for line in lines_of(geometry)]
        self.point = _points([geometry.coordinates]) if isinstance(geometry, Point) else np.empty((0, 2))
        self._half = 0.5 * width
        places = np.concatenate([*self.rings, *self.lines, self.point])
        self.low, self.high = places.min(axis=0) - self._half, places.max(axis=0) + self._half

    def distances(self, points: Points) -> Points:
        """Return the distance of (n, 2) points from the area [m], (n,) float64; 0 within it."""
        block = max(1, AT_ONCE // sum(map(len, [*self.rings, *self.lines, self.point])))
        parts = [self._distances(points[begin : begin + block]) for begin in range(0, len(points), block)]
        return np.concatenate(parts) if parts else np.empty(0)

    def _distances(self, points: Points) -> Points:
        distances = np.full(len(points), np.inf)
        inside = np.zeros(len(points), np.bool_)
        for outer, *holes in self.polygons:
            inside |= within_polygon(outer, points) & ~_within_any(holes, points)
        for ring in self.rings:
            distances = np.minimum(distances, _apart(ring, np.roll(ring, -1, axis=0), points))
        for line in self.lines:
            distances = np.minimum(distances, np.maximum(_apart(line[:-1], line[1:], points) - self._half, 0.0))
        for place in self.point:
            distances = np.minimum(distances, np.hypot(*(points - place).T))
        distances[inside] = 0.0
        return distances

    def directions(self, points: Points) -> Points:
        """Return the directions of the nearest lines, as unit vectors, (n, 2) float64; there are lines."""
        starts = np.concatenate([line[:-1] for line in self.lines])
        ends = np.concatenate([line[1:] for line in self.lines])
        nearest = distances_to_edges(starts, ends, points[:, np.newaxis]).argmin(axis=1)
        along = (ends - starts)[nearest]
        return np.asarray(along / np.hypot(*along.T)[:, np.newaxis])


def _points(places: Ring) -> Points:
    return np.array([place[:2] for place in places])


def _within_any(rings: list[Points], points: Points) -> NDArray[np.bool_]:
    within = np.zeros(len(points), np.bool_)
    for ring in rings:
        within |= within_polygon(ring, points)
    return within


def _apart(starts: Points, ends: Points, points: Points) -> Points:
    return np.asarray(distances_to_edges(starts, ends, points[:, np.newaxis]).min(axis=1))


def polygons_of(geometry: Geometry) -> list[list[Ring]]:
    """Return all polygons of a geometry, each as its outer ring and its holes."""
    match geometry:
        case Polygon():
            return [geometry.coordinates]
        case MultiPolygon():
            return geometry.coordinates
        case _:
            return []


def rings_of(geometry: Geometry) -> list[Ring]:
    """Return all rings of a geometry."""
    return [ring for polygon in polygons_of(geometry) for ring in polygon]


def lines_of(geometry: Geometry) -> list[Ring]:
    """Return all lines of a geometry."""
    match geometry:
        case LineString():
            return [geometry.coordinates]
        case MultiLineString():
            return geometry.coordinates
        case _:
            return []


def first_place(tree: Any, depth: int = 8) -> tuple[float, float] | None:
    """Return the first finite position in decoded GeoJSON of any kind, valid or not; None if it has none."""
    if isinstance(tree, dict):
        return first_place(tree.get("coordinates", tree.get("geometries")), depth - 1)
    if not isinstance(tree, list) or depth <= 0:
        return None
    if len(tree) > 1 and all(type(each) in (int, float) and abs(each) < math.inf for each in tree[:2]):
        return float(tree[0]), float(tree[1])
    return next((place for part in tree if (place := first_place(part, depth - 1)) is not None), None)


def check_geometry(geometry: Geometry, name: str) -> int:
    """Return the number of positions of a geometry.

    Raises
    ------
    InvalidZones
        It has no positions, too few for a ring or line, or one that is not finite or too far; the text names ``name``,
        and the fault has a place.
    """
    rings, lines = rings_of(geometry), lines_of(geometry)
    points = [geometry.coordinates] if isinstance(geometry, Point) else []
    if not any(rings) and not any(lines) and not any(points):
        raise InvalidZones(f"zone {name!r} has no coordinates: draw it, or leave the feature out")
    for place in [place for part in rings + lines for place in part] + points:
        if len(place) < 2 or not all(math.isfinite(each) and abs(each) <= FARTHEST for each in place[:2]):
            raise _wrong(
                geometry, name,
                f"a position must be x, y in metres up to {FARTHEST:g} in the map's frame, not {place!s:.80}",
                place,
            )  # fmt: skip
    for ring in rings:
        if len({tuple(place[:2]) for place in ring}) < 3:
            raise _wrong(geometry, name, "a ring needs three different positions or more", ring)
    for line in lines:
        if any(one[:2] == other[:2] for one, other in pairwise(line)) or len(line) < 2:
            text = "a line needs two positions or more, each different from the one before"
            raise _wrong(geometry, name, text, line)
    return sum(map(len, rings + lines)) + len(points)


def _wrong(geometry: Geometry, name: str, text: str, where: Any) -> InvalidZones:
    """Return the error for a part of a geometry, with its place, or else the place of the first position."""
    place = first_place(where) or first_place(geometry.coordinates)
    at = "" if place is None else f", at ({place[0]:.6g}, {place[1]:.6g})"
    return InvalidZones(f"zone {name!r}: {text}{at}", [ZoneFault(name, text, place)])
