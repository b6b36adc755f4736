"""Lifts of a building of Open-RMF: their cars and landing doors on each floor.

Source: ``rmf_building_map_tools`` of 2025-06. A lift is placed by pixels of its reference floor, and its heading is in
the frame of the building. Its width is along x and its depth along y of the car; doors are in metres from the middle
of the car, on the side to which they are nearest.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from ppaas.imports.graphs.model.route_graph import GraphMark, GraphOptions, Place
from ppaas.imports.graphs.model.unique_names import unique_name
from ppaas.imports.graphs.rmf.fields import number
from ppaas.imports.graphs.rmf.levels import RmfBuilding, places_of, raw_place
from ppaas.imports.report import ImportReport

_GAP = 0.05
"""Distance between the car and its landing doors [m]."""


class RmfLift(NamedTuple):
    """Lift of a building.

    Parameters
    ----------
    name : str
    centre : Place
        Middle of its car, in the frame of the building [m].
    yaw : float
        Heading of its car [rad].
    size : Place
        Width and depth of its car [m].
    doors : dict of str to pair of Place
        Ends of its landing doors, by name.
    stops : dict of str to tuple of str
        Names of the doors that open on each floor that it serves.
    """

    name: str
    centre: Place
    yaw: float
    size: Place
    doors: Mapping[str, tuple[Place, Place]]
    stops: Mapping[str, tuple[str, ...]]

    def marks(self, level: str) -> list[GraphMark]:
        """Return the car and the doors of the lift on a floor; nothing if it does not stop there."""
        if level not in self.stops:
            return []
        width, depth = self.size
        corners = ((-width, -depth), (width, -depth), (width, depth), (-width, depth))
        outline = tuple(_at(self.centre, self.yaw, (0.5 * x, 0.5 * y)) for x, y in corners)
        part = f"lifts.{self.name}"
        return [
            GraphMark(self.name, "lift", outline, self.name, part=part),
            *(
                GraphMark(f"{self.name} {door}", "door", self.doors[door], self.name, part=f"{part}.doors.{door}")
                for door in self.stops[level]
            ),
        ]


def lifts_of(building: RmfBuilding, report: ImportReport, options: GraphOptions) -> list[RmfLift]:
    """Return the lifts of a building; what is no lift is refused in the report."""
    lifts = building.tree.get("lifts")
    found: dict[str, RmfLift] = {}
    for name, given in lifts.items() if isinstance(lifts, dict) else ():
        lift = _lift(str(name), given, building, report, options)
        if lift is not None:
            own = unique_name(lift.name, found)
            found[own] = lift._replace(name=own)
    return list(found.values())


def _lift(name: str, given: Any, building: RmfBuilding, report: ImportReport, options: GraphOptions) -> RmfLift | None:
    part = f"lifts.{name}"
    fields = given if isinstance(given, dict) else {}
    raw = raw_place([fields.get("x"), fields.get("y")])
    width, depth, yaw = (number(fields.get(field)) for field in ("width", "depth", "yaw"))
    floor = str(fields.get("reference_floor_name") or building.reference)
    if raw is None or not (width and depth and width > 0.0 and depth > 0.0):
        report.refused(part, "a lift has x, y, width and depth")
        return None
    if floor not in building.levels:
        report.refused(part, f"its reference_floor_name {floor!r} is no level: it may be {', '.join(building.levels)}")
        return None
    [centre] = places_of(building, floor, [raw], ImportReport(report.source), options)
    places = {
        str(door): ends
        for door, each in _mapping(fields.get("doors")).items()
        if (ends := _ends(each, centre, yaw or 0.0, (width, depth))) is not None
    }
    stops = _stops(part, _mapping(fields.get("level_doors")), places, building, report)
    report.translated(part, f"a car of {width:g} × {depth:g} m that stops on {', '.join(stops) or 'no floor'}")
    return RmfLift(name, centre, yaw or 0.0, (width, depth), places, stops)


def _stops(
    part: str,
    given: Mapping[str, Any],
    places: Mapping[str, tuple[Place, Place]],
    building: RmfBuilding,
    report: ImportReport,
) -> dict[str, tuple[str, ...]]:
    stops: dict[str, tuple[str, ...]] = {}
    for level, doors in given.items():
        if level not in building.levels:
            report.refused(f"{part}.level_doors.{level}", f"no such level: there are {', '.join(building.levels)}")
            continue
        names = [str(door) for door in doors] if isinstance(doors, list | dict) else []
        for door in names:
            if door not in places:
                report.refused(f"{part}.level_doors.{level}", f"the lift has no door {door!r} with x, y and width")
        stops[level] = tuple(dict.fromkeys(door for door in names if door in places))
    return stops


def _ends(given: Any, centre: Place, yaw: float, size: Place) -> tuple[Place, Place] | None:
    """Return the ends of a landing door, which is on the side of the car to which its middle is nearest."""
    fields = _mapping(given)
    middle, width = raw_place([fields.get("x"), fields.get("y")]), number(fields.get("width"))
    if middle is None or not width or width <= 0.0:
        return None
    x, y = middle
    half = 0.5 * width
    if abs(abs(x) - 0.5 * size[0]) <= abs(abs(y) - 0.5 * size[1]):
        beside = math.copysign(0.5 * size[0] + _GAP, x)
        ends = (beside, y - half), (beside, y + half)
    else:
        before = math.copysign(0.5 * size[1] + _GAP, y)
        ends = (x - half, before), (x + half, before)
    return _at(centre, yaw, ends[0]), _at(centre, yaw, ends[1])


def _at(centre: Place, yaw: float, place: Place) -> Place:
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return centre[0] + cosine * place[0] - sine * place[1], centre[1] + sine * place[0] + cosine * place[1]


def _mapping(value: Any) -> Mapping[str, Any]:
    return {str(key): each for key, each in value.items()} if isinstance(value, dict) else {}
