"""Zones of a graph: lanes along its edges, and zones and stations for what else it says."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, get_args

from ppaas.fleet.lane_drawing import STRAIGHT
from ppaas.imports.graphs.chains import LaneChain, Link, chains_of, links_of
from ppaas.imports.graphs.limits import within_limits
from ppaas.imports.graphs.model.gathered import GatheredNotes
from ppaas.imports.graphs.model.route_graph import GraphMark, GraphStation, Place, RouteGraph
from ppaas.imports.report import ImportReport
from ppaas.zones.gate import checked_zones
from ppaas.zones.reading import geojson_of
from ppaas.zones.shapes import LineString, MultiLineString, MultiPolygon, Point, Polygon
from ppaas.zones.validity import line_fault
from ppaas.zones.zone import (
    LONGEST_NAME,
    MOST_CAPACITIES,
    MOST_MARKS,
    MOST_ON_LANES,
    MOST_POSITIONS,
    AnyRule,
    Capacity,
    Dock,
    Door,
    Lane,
    LiftCar,
    NoStop,
    SpeedZone,
    Station,
    Use,
    Zone,
    ZoneSet,
)

if TYPE_CHECKING:
    import shapely

BESIDE = 0.1
"""Half of the width of a zone along a lane [m]: a robot on the lane touches it, one on the next lane does not."""

MOST_LANES = 300
"""Largest number of zones for lanes; more lanes share some, so that other zones have room."""

USES = get_args(Use)
"""What a station may be for."""

_ROUND = 4
"""Decimals of positions [m]."""


def zones_of_graph(graph: RouteGraph, report: ImportReport) -> ZoneSet:
    """Return the zones of a graph.

    Each chain of edges becomes a lane; limits of the speed, groups of edges and places to pass become zones along the
    lanes, and named places stations. What a map has no room for is refused in the report.

    Parameters
    ----------
    graph : RouteGraph
        In the frame of the map.
    report : ImportReport
        Takes what became of the edges, and what is left out.
    """
    notes = GatheredNotes()
    names, links = links_of(graph, notes)
    chains = within_limits(chains_of(links), MOST_ON_LANES, STRAIGHT, notes)
    zones = _Zones(notes)
    for name, lines, one_way in _lanes(chains, names, notes):
        rounded = [_rounded(line) for line in lines]
        geometry = LineString(rounded[0]) if len(rounded) == 1 else MultiLineString(rounded)
        zones.add(name, Lane, geometry, one_way=one_way)
    kept = [link for chain in chains for link in chain.links]
    _add_limits(zones, kept)
    if graph.passing:
        zones.add("places to pass", NoStop, MultiPolygon([_outline(_disc(place)) for place in graph.passing]))
    _add_stations(zones, graph.stations, notes)
    _add_marks(zones, graph.marks, notes)
    if links:
        ways = sum(chain.one_way for chain in chains)
        report.translated(
            f"{len(graph.edges)} edges",
            f"{len(chains)} lanes, {ways} of them one way, of {len(kept)} straight parts",
        )
    notes.write(report)
    return checked_zones(geojson_of(ZoneSet(zones.found))).zones


class _Zones:
    """Zones with names that no other has."""

    def __init__(self, notes: GatheredNotes) -> None:
        self.found: list[Zone] = []
        self.notes = notes
        self._names: set[str] = set()
        self._left = MOST_POSITIONS - MOST_ON_LANES - MOST_MARKS

    def add(self, name: str, rule: type[AnyRule], geometry: Any, **fields: Any) -> None:
        """Add a zone."""
        self.found.append(Zone(geometry, rule(name=self._own(name), **fields)))

    def add_along(self, name: str, rule: type[AnyRule], links: Sequence[Link], **fields: Any) -> None:
        """Add a zone along links, unless it has more positions than are left."""
        geometry = _along(links)
        size = sum(len(ring) for rings in geometry.coordinates for ring in rings)
        if size > self._left:
            self.notes.refused(name, f"a map may have {MOST_POSITIONS} positions of zones; this zone was left out")
            return
        self._left -= size
        self.add(name, rule, geometry, **fields)

    def _own(self, name: str) -> str:
        name = " ".join(name.split())[:LONGEST_NAME] or "lane"
        own, number = name, 2
        while own in self._names:
            end = f" {number}"
            own, number = name[: LONGEST_NAME - len(end)] + end, number + 1
        self._names.add(own)
        return own


# -- lanes -------------------------------------------------------------------------------------------------------------


def _lanes(
    chains: Sequence[LaneChain], names: Sequence[str], notes: GatheredNotes
) -> Iterator[tuple[str, list[list[Place]], bool]]:
    """Yield the name of each zone of lanes, its lines, and whether they are one way."""
    share = max(math.ceil(len(chains) / (MOST_LANES - 1)), 1)
    for one_way in (False, True):
        alike = [chain for chain in chains if chain.one_way == one_way]
        for begin in range(0, len(alike), share):
            bundle = alike[begin : begin + share]
            lines = [line for chain in bundle for line in _lines(chain, notes)]
            if lines:
                yield _name(bundle[0], names), lines, one_way


def _name(chain: LaneChain, names: Sequence[str]) -> str:
    start, end = names[chain.places[0]], names[chain.places[-1]]
    return f"{start} - {end}" if start and end else chain.links[0].name


def _lines(chain: LaneChain, notes: GatheredNotes) -> list[list[Place]]:
    """Return the line of a chain, or, if that would lead back on itself, those of its links."""
    if not line_fault(chain.points):
        return [chain.points]
    found = []
    for link in chain.links:
        if fault := line_fault(link.points):
            notes.refused(f"lane {link.name!r}", fault)
        else:
            found.append(link.points)
    return found


def _rounded(places: Iterable[Place]) -> list[list[float]]:
    return [[round(x, _ROUND), round(y, _ROUND)] for x, y in places]


# -- zones along lanes -------------------------------------------------------------------------------------------------


def _add_limits(zones: _Zones, links: Sequence[Link]) -> None:
    for limit in sorted({link.max_speed for link in links if link.max_speed is not None}):
        along = [link for link in links if link.max_speed == limit]
        zones.add_along(f"{limit:g} m/s", SpeedZone, along, max_speed=limit)
    for percent in sorted({link.percent for link in links if link.percent is not None}):
        along = [link for link in links if link.percent == percent]
        zones.add_along(f"{percent:g} percent", SpeedZone, along, percent=percent)
    groups = list(dict.fromkeys(group for link in links for group in link.groups))
    for number, group in enumerate(groups):
        if number < MOST_CAPACITIES:
            zones.add_along(group, Capacity, [link for link in links if group in link.groups], robots=1)
        else:
            zones.notes.refused(f"group {group!r}", f"a map may have {MOST_CAPACITIES} zones of the kind 'capacity'")


def _along(links: Sequence[Link]) -> MultiPolygon:
    import shapely  # noqa: PLC0415 - only imports of graphs need it

    lines = [shapely.LineString(link.points) for link in links]
    area = shapely.union_all(shapely.buffer(lines, BESIDE, cap_style="flat", join_style="mitre", mitre_limit=2.0))
    return MultiPolygon([_outline(part) for part in shapely.get_parts(shapely.simplify(area, BESIDE / 10.0))])


def _outline(part: "shapely.Polygon") -> list[list[list[float]]]:
    return [_rounded(ring.coords) for ring in (part.exterior, *part.interiors)]


def _disc(place: Place) -> "shapely.Polygon":
    import shapely  # noqa: PLC0415 - only imports of graphs need it

    return shapely.Point(place).buffer(BESIDE, quad_segs=2)


# -- stations ----------------------------------------------------------------------------------------------------------


def _add_stations(zones: _Zones, stations: Sequence[GraphStation], notes: GatheredNotes) -> None:
    for number, station in enumerate(stations):
        if number >= MOST_MARKS:
            notes.refused(station.part, f"a map may have {MOST_MARKS} stations")
            continue
        yaw = None if station.yaw is None else round(station.yaw, _ROUND)
        uses = [use for use in dict.fromkeys(station.uses) if use in USES]
        zones.add(station.name, Station, Point(_rounded([station.place])[0]), yaw=yaw, uses=uses)
        what = f"station for {', '.join(uses)}" if uses else "station"
        notes.translated(station.part, what)


def _add_marks(zones: _Zones, marks: Sequence[GraphMark], notes: GatheredNotes) -> None:
    """Add doors, cars of lifts and docks; stations come before them, and names that are taken get a number."""
    left = MOST_MARKS - sum(isinstance(zone.rule, Station) for zone in zones.found)
    for number, mark in enumerate(marks):
        if number >= left:
            notes.refused(mark.part, f"a map may have {MOST_MARKS} stations, doors and docks")
            continue
        places = _rounded(mark.places)
        match mark.kind:
            case "door":
                zones.add(mark.name, Door, LineString(places), lift=mark.lift)
            case "lift":
                zones.add(mark.name, LiftCar, Polygon([[*places, places[0]]]), lift=mark.lift)
            case "dock":
                yaw = round(mark.yaw or 0.0, _ROUND)
                zones.add(mark.name, Dock, Point(places[0]), yaw=yaw, charges=mark.charges)
                notes.translated(mark.part, "a dock, with the heading of a lane that ends there")
