"""Coordinates of the floors of a building of Open-RMF: of pixels, metres or the earth, in metres.

Source: ``rmf_building_map_tools`` of 2025-06. Without a ``coordinate_system``, positions are pixels of the drawing, y
downwards. The reference floor takes its scale from its measurements; the others take scale, rotation and shift from
fiducials of the same names.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from ppaas.errors import InvalidInput
from ppaas.imports.graphs.model.degrees import WGS84, metres_around, transformed
from ppaas.imports.graphs.model.route_graph import GraphOptions, Place
from ppaas.imports.graphs.rmf.fields import items, number
from ppaas.imports.report import ImportReport

EDITOR_SCALE = 0.05
"""Metres of a pixel with which the traffic editor begins."""

UNMEASURED = "as in a new file of the editor, since it has no measurements: if that is wrong, give --scale METRES"

IMAGE, MERCATOR, METRES, EARTH = "reference_image", "web_mercator", "cartesian_meters", "wgs84"

SYSTEMS = (IMAGE, MERCATOR, METRES, EARTH)

_RADIUS = 6_378_137.0
"""Radius of the earth in the projection of web maps [m]."""

_WEB = "EPSG:3857"


AGREE = 0.5
"""Distance between fiducials of two floors up to which they agree [m]."""


class Similarity(NamedTuple):
    """Scale, rotation [rad] and shift [m] of a floor."""

    scale: float
    rotation: float = 0.0
    shift: Place = (0.0, 0.0)

    def place(self, x: float, y: float) -> Place:
        """Return a position of the floor, in metres."""
        cosine, sine = math.cos(self.rotation), math.sin(self.rotation)
        return (
            self.scale * (cosine * x - sine * y) + self.shift[0],
            self.scale * (sine * x + cosine * y) + self.shift[1],
        )

    def back(self) -> tuple[float, float, float]:
        """Return the pose of the frame of the building in the frame of the floor, both in metres."""
        cosine, sine = math.cos(self.rotation), math.sin(self.rotation)
        x, y = self.shift
        return -cosine * x - sine * y, sine * x - cosine * y, -self.rotation


class RmfBuilding(NamedTuple):
    """Building of Open-RMF.

    Parameters
    ----------
    tree : Mapping
        Decoded YAML.
    levels : dict of str to Mapping
        Floors by name.
    reference : str
        Name of the reference floor.
    """

    tree: Mapping[str, Any]
    levels: Mapping[str, Mapping[str, Any]]
    reference: str

    def parameter(self, name: str) -> Any:
        """Return the value of a parameter; None if it has none."""
        parameters = self.tree.get("parameters")
        return value_of(parameters.get(name)) if isinstance(parameters, dict) else None


def value_of(parameter: Any) -> Any:
    """Return the value of a parameter, which is a list of a type and the value."""
    return parameter[1] if isinstance(parameter, list) and len(parameter) > 1 else parameter


def raw_place(given: Any) -> Place | None:
    """Return x, y of a vertex or fiducial as in the file; None if it has none."""
    if not isinstance(given, list) or len(given) < 2:
        return None
    x, y = number(given[0]), number(given[1])
    return None if x is None or y is None else (x, y)


def places_of(
    building: RmfBuilding, level: str, raw: Sequence[Place], report: ImportReport, options: GraphOptions
) -> list[Place]:
    """Return positions of a floor in metres.

    Raises
    ------
    InvalidInput
        The scale is not known, or a coordinate system.
    """
    system = building.tree.get("coordinate_system") or IMAGE
    match system:
        case "reference_image":
            similarity = similarity_of(building, level, report, options)
            return [similarity.place(x, -y) for x, y in raw]
        case "cartesian_meters":
            report.taken("coordinate_system", "metres")
            return list(raw)
        case "wgs84":
            return _from_earth(building, raw, report, options)
        case "web_mercator":
            web = [(_RADIUS * math.pi * (x - 128) / 128, _RADIUS * math.pi * (128 - y) / 128) for x, y in raw]
            return _from_earth(building, transformed(web, _WEB, WGS84), report, options)
        case _:
            raise InvalidInput(f"coordinate_system {system!r} is not known: Open-RMF has {', '.join(SYSTEMS)}")


def _from_earth(
    building: RmfBuilding, degrees: Sequence[Place], report: ImportReport, options: GraphOptions
) -> list[Place]:
    crs = building.parameter("generate_crs")
    if options.anchor is not None or not isinstance(crs, str) or not crs:
        report.translated("coordinate_system", "longitudes and latitudes, in metres around the anchor")
        return metres_around(degrees, options.anchor, report.source)
    x, y = (number(building.parameter(f"suggested_offset_{axis}")) or 0.0 for axis in "xy")
    report.translated(
        "coordinate_system",
        f"longitudes and latitudes, in metres of {crs} less the suggested offset ({x:g}, {y:g}); with --anchor "
        "LATITUDE LONGITUDE, in metres around that point",
    )
    return [(east - x, north - y) for east, north in transformed(degrees, WGS84, crs)]


# -- drawings: pixels --------------------------------------------------------------------------------------------------


def similarity_of(building: RmfBuilding, level: str, report: ImportReport, options: GraphOptions) -> Similarity:
    """Return the scale, rotation and shift of a floor in pixels, and report where they come from."""
    own = options.scale or _measured(building.levels[level])
    if level == building.reference:
        count = _count(building.levels[level])
        source = "by --scale" if options.scale else f"by {count} measurements" if own else UNMEASURED
        own = own or EDITOR_SCALE
        report.translated(f"levels.{level}.measurements", f"a pixel is {own:.6g} m, {source}; y upwards")
        return Similarity(own)
    scale = options.scale or _measured(building.levels[building.reference])
    ours, theirs = (_fiducials(building.levels[name]) for name in (level, building.reference))
    common = [name for name in theirs if name in ours]
    part = f"levels.{level}.fiducials"
    if scale is not None and len(common) > 1:
        found = _fitted([theirs[name] for name in common], [ours[name] for name in common], scale)
        errors = [
            math.dist(found.place(*ours[name]), (scale * theirs[name][0], scale * theirs[name][1])) for name in common
        ]
        worst = common[errors.index(max(errors))]
        if max(errors) > AGREE:
            report.refused(
                f"{part} {worst}",
                f"fiducials of {level} and {building.reference} do not agree: this one is {max(errors):.2f} m from "
                f"where the fit of all {len(common)} puts it; move it in one of the drawings",
            )
        report.translated(
            part,
            f"scale {found.scale:.6g} m and rotation {math.degrees(found.rotation):.2f}° by {len(common)} fiducials in "
            f"common with {building.reference}, which are {max(errors):.3f} m apart at most",
        )
        return found
    source = "by the floor's own measurements" if own else f"as on {building.reference}" if scale else UNMEASURED
    own = own or scale or EDITOR_SCALE
    shift = (0.0, 0.0)
    if len(common) == 1 and scale is not None:
        (x, y), (to_x, to_y) = ours[common[0]], theirs[common[0]]
        shift = scale * to_x - own * x, scale * to_y - own * y
    report.translated(
        part,
        f"{len(common)} fiducials in common with {building.reference}, where two are needed: a pixel is {own:.6g} m, "
        f"{source}, and the rotation is taken as 0; Open-RMF would stay in pixels",
    )
    return Similarity(own, 0.0, shift)


def _measured(level: Mapping[str, Any]) -> float | None:
    """Return the mean of metres by pixels of the measurements of a floor; None if it has none."""
    found = _measurements(level)
    return float(np.mean(found)) if found else None


def _count(level: Mapping[str, Any]) -> int:
    return len(_measurements(level))


def _measurements(level: Mapping[str, Any]) -> list[float]:
    vertices, found = items(level, "vertices"), []
    for each in items(level, "measurements"):
        try:
            one, other = (raw_place(vertices[int(each[at])]) for at in (0, 1))
            metres = number(value_of(each[2]["distance"]))
        except (IndexError, KeyError, OverflowError, TypeError, ValueError):
            continue
        pixels = math.dist(one, other) if one and other else 0.0
        if metres and metres > 0.0 and pixels > 0.0:
            found.append(metres / pixels)
    return found


def _fiducials(level: Mapping[str, Any]) -> dict[str, Place]:
    """Return the fiducials of a floor by name, y upwards."""
    found: dict[str, Place] = {}
    for each in items(level, "fiducials"):
        place = raw_place(each)
        if place is not None and len(each) > 2 and each[2]:
            found.setdefault(str(each[2]), (place[0], -place[1]))
    return found


def _fitted(theirs: Sequence[Place], ours: Sequence[Place], scale: float) -> Similarity:
    """Return the similarity by mean ratios of distances and mean bearings of all pairs, as Open-RMF has it."""
    pairs = [pair for pair in combinations(range(len(ours)), 2) if math.dist(*(theirs[at] for at in pair)) > 0.0]
    ratios = [math.dist(*(ours[at] for at in pair)) / math.dist(*(theirs[at] for at in pair)) for pair in pairs]
    turns = [_bearing(*(ours[at] for at in pair)) - _bearing(*(theirs[at] for at in pair)) for pair in pairs]
    ratio = float(np.mean(ratios)) if ratios else 0.0
    if not ratio > 0.0:
        raise InvalidInput("fiducials with different names are at one place: move one of them")
    rotation = -math.atan2(float(np.sum(np.sin(turns))), float(np.sum(np.cos(turns))))
    turned = Similarity(scale / ratio, rotation)
    places = np.array([turned.place(*each) for each in ours])
    x, y = (scale * np.array(theirs) - places).mean(axis=0)
    return Similarity(scale / ratio, rotation, (float(x), float(y)))


def _bearing(one: Place, other: Place) -> float:
    return math.atan2(other[1] - one[1], other[0] - one[0])
