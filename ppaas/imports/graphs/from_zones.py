"""Graph of the lanes of a map, as other programs have it: nodes at all corners and crossings, and at stations."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.fleet.lane_drawing import JOINS, lines_in, network_of
from ppaas.imports.graphs.model.gathered import GatheredNotes
from ppaas.imports.graphs.model.route_graph import GraphEdge, GraphNode, GraphStation, RouteGraph
from ppaas.imports.report import ImportReport
from ppaas.polygons import Points, distances_to_edges
from ppaas.zones.shapes import Point
from ppaas.zones.zone import Lane, SpeedZone, Station, Zone, ZoneSet

FARTHEST_STATION = 5.0
"""Distance from the lanes up to which a station is a node on the nearest lane [m]."""

_SAMPLES = (0.25, 0.5, 0.75)
"""Parts of an edge that a zone must have for its limit to be that of the edge."""


def graph_of_zones(zones: ZoneSet, report: ImportReport) -> RouteGraph:
    """Return the graph of the lanes and stations of a map.

    Parameters
    ----------
    zones : ZoneSet
    report : ImportReport
        Takes what became of each zone.

    Raises
    ------
    InvalidInput
        The map has no lanes.
    """
    lines = lines_in(zones.zones)
    if not lines:
        raise InvalidInput("the map has no lanes: a graph is made of zones of the kind 'lane'")
    places, names = network_of(lines, every_corner=True)
    splitting = _Splitting(places, names)
    notes = GatheredNotes()
    stations = [station for zone in zones.stations if (station := splitting.add_station(zone, notes)) is not None]
    places, names = splitting.places, splitting.names
    called = {place: name for name, place in splitting.stations.items()}
    nodes = {
        str(at): GraphNode(called.get(at, f"n{at}"), (round(x, 4), round(y, 4)), "")
        for at, (x, y) in enumerate(places.tolist())
    }
    parts = np.array(list(names), np.int64)
    speeds, percents = _limits(zones.zones, places[parts[:, 0]], places[parts[:, 1]], notes)
    edges = [
        GraphEdge(name, str(one), str(other), (), speeds[at], percents[at], "", name)
        for at, ((one, other), name) in enumerate(names.items())
    ]
    _note_zones(zones.zones, notes)
    report.translated("lanes", f"{len(nodes)} nodes and {len(edges)} edges, each for one way")
    notes.write(report)
    return RouteGraph(nodes, edges, stations, [])


class _Splitting:
    """Network whose parts are divided where stations are."""

    def __init__(self, places: Points, names: dict[tuple[int, int], str]) -> None:
        self.places, self.names = places, dict(names)
        self.stations: dict[str, int] = {}

    def add_station(self, zone: Zone, notes: GatheredNotes) -> GraphStation | None:
        """Make a station a node; None if it is too far from all lanes."""
        assert isinstance(zone.rule, Station)
        assert isinstance(zone.geometry, Point)
        at = np.array(zone.geometry.coordinates[:2])
        parts = np.array(list(self.names))
        begins, ends = self.places[parts[:, 0]], self.places[parts[:, 1]]
        apart = distances_to_edges(begins, ends, at)
        nearest = int(apart.argmin())
        if apart[nearest] > FARTHEST_STATION:
            notes.refused(f"station {zone.name!r}", f"it is {apart[nearest]:.1f} m from the nearest lane")
            return None
        place = self._place(at, parts[nearest])
        self.stations[zone.name] = place
        beside = "" if apart[nearest] <= JOINS else f", {apart[nearest]:.2f} m beside it"
        notes.translated(f"station {zone.name!r}", f"a node on the nearest lane{beside}")
        x, y = self.places[place].tolist()
        return GraphStation(zone.name, (round(x, 4), round(y, 4)), zone.rule.yaw, tuple(zone.rule.uses), str(place))

    def _place(self, at: NDArray[np.float64], part: NDArray[np.int64]) -> int:
        one, other = part.tolist()
        line = self.places[other] - self.places[one]
        along = float(np.clip((at - self.places[one]) @ line / (line @ line), 0.0, 1.0))
        found = self.places[one] + along * line
        for end in (one, other):
            if np.hypot(*(self.places[end] - found)) <= JOINS and end not in self.stations.values():
                return int(end)
        new = len(self.places)
        self.places = np.vstack((self.places, found))
        for begin, end in ((one, other), (other, one)):
            if name := self.names.pop((begin, end), None):
                self.names[begin, new] = self.names[new, end] = name
        return new


def _limits(
    zones: Sequence[Zone], begins: Points, ends: Points, notes: GatheredNotes
) -> tuple[list[float | None], list[float | None]]:
    """Return the lowest limits of the speed of each edge [m/s], and as percentages."""
    speeds: list[float | None] = [None] * len(begins)
    percents: list[float | None] = [None] * len(begins)
    for zone in zones:
        if not isinstance(zone.rule, SpeedZone):
            continue
        area = zone.area
        inside = np.ones(len(begins), np.bool_)
        for part in _SAMPLES:
            inside &= area.distances(begins + part * (ends - begins)) <= 0.0
        limit = zone.rule.max_speed if zone.rule.max_speed is not None else zone.rule.percent
        limits = speeds if zone.rule.max_speed is not None else percents
        for at in np.nonzero(inside)[0].tolist():
            limits[at] = min(limits[at] or np.inf, limit or np.inf)
        what = f"the limit of {int(inside.sum())} edges"
        if zone.rule.times:
            what += "; its times are left out"
        if inside.any():
            notes.translated(f"speed_limit {zone.name!r}", what)
        else:
            notes.without_effect(f"speed_limit {zone.name!r}", "no edge is in it")
    return speeds, percents


def _note_zones(zones: Sequence[Zone], notes: GatheredNotes) -> None:
    for zone in zones:
        if not isinstance(zone.rule, Lane | SpeedZone | Station):
            kind = str(zone.rule.__struct_config__.tag)
            notes.without_effect(f"{kind} {zone.name!r}", "graphs have no such zones")
