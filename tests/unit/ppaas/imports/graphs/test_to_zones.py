"""Zones of graphs: lanes, limits, groups and stations, within the limits of a map."""

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.imports.graphs.model.route_graph import GraphStation, RouteGraph
from ppaas.imports.graphs.to_zones import zones_of_graph
from ppaas.imports.report import ImportReport
from ppaas.zones.gate import checked_zones
from ppaas.zones.reading import geojson_of
from ppaas.zones.zone import MOST_CAPACITIES, MOST_MARKS, MOST_ON_LANES, Capacity, Lane, SpeedZone, Station, ZoneSet
from tests.support.budget import examples
from tests.support.graphs import NO_EFFECT, REFUSED, SQUARE, TRANSLATED, both_ways, graph_of, segments_of, texts

GRID = {5 * y + x: (2.0 * x, 2.0 * y) for y in range(5) for x in range(5)}
PAIRS = [
    (one, other)
    for one, other in itertools.permutations(GRID, 2)
    if sum(abs(a - b) for a, b in zip(GRID[one], GRID[other], strict=True)) == 2.0
]


def zones_of(graph: RouteGraph) -> tuple[ZoneSet, ImportReport]:
    report = ImportReport("graph")
    zones = zones_of_graph(graph, report)
    assert checked_zones(geojson_of(zones)).zones == zones
    return zones, report


@settings(max_examples=examples(60))
@given(st.sets(st.sampled_from(PAIRS), min_size=1, max_size=40))
def test_lanes_lead_along_all_edges_and_no_others(edges: set[tuple[int, int]]) -> None:
    zones, _ = zones_of(graph_of(GRID, sorted(edges)))
    assert segments_of(zones) == {(GRID[one], GRID[other]) for one, other in edges}


def test_edges_one_after_the_other_are_one_lane() -> None:
    zones, report = zones_of(graph_of(SQUARE, [*both_ways((0, 1), (1, 2)), (2, 3)]))
    assert [(zone.name, zone.rule) for zone in zones.zones] == [
        ("p0 - p2", Lane(name="p0 - p2")),
        ("p2 - p3", Lane(name="p2 - p3", one_way=True)),
    ]
    assert texts(report, TRANSLATED)["5 edges"] == "2 lanes, 1 of them one way, of 3 straight parts"


def test_a_ring_is_one_lane() -> None:
    zones, _ = zones_of(graph_of(SQUARE, [(0, 1), (1, 2), (2, 3), (3, 0)]))
    [ring] = zones.zones
    assert ring.geometry.coordinates[0] == ring.geometry.coordinates[-1]


def test_a_lane_that_leads_back_on_itself_is_divided() -> None:
    places = {0: (0.0, 0.0), 1: (10.0, 0.0), 2: (10.0, 5.0), 3: (5.0, 0.0), 4: (1.0, 0.0)}
    zones, _ = zones_of(graph_of(places, both_ways((0, 1), (1, 2), (2, 3), (3, 4))))
    assert ((5.0, 0.0), (1.0, 0.0)) in segments_of(zones)
    assert len(segments_of(zones)) == 8


def test_limits_of_the_speed_and_groups_are_zones_along_the_lanes() -> None:
    graph = graph_of(SQUARE, both_ways((0, 1)), max_speed=0.4, group="door")
    graph.edges += graph_of(SQUARE, [(1, 2)], percent=50.0).edges
    zones, _ = zones_of(graph)
    by_name = {zone.name: zone for zone in zones.zones}
    assert by_name["0.4 m/s"].rule == SpeedZone(name="0.4 m/s", max_speed=0.4)
    assert by_name["50 percent"].rule == SpeedZone(name="50 percent", percent=50.0)
    assert by_name["door"].rule == Capacity(name="door", robots=1)
    assert by_name["0.4 m/s"].area.distances(_middle(0, 1)) == 0.0
    assert by_name["0.4 m/s"].area.distances(_middle(1, 2)) > 1.0


def _middle(one: int, other: int) -> "object":
    import numpy as np

    return np.array([SQUARE[one], SQUARE[other]]).mean(axis=0, keepdims=True)


def test_edges_on_each_other_have_the_lower_limit() -> None:
    graph = graph_of(SQUARE, [(0, 1)], max_speed=0.8)
    graph.edges += graph_of(SQUARE, [(0, 1), (1, 0)], max_speed=0.3).edges
    zones, report = zones_of(graph)
    assert [zone.name for zone in zones.zones] == ["p0 - p1", "0.3 m/s"]
    assert texts(report, TRANSLATED)["edges[0]"] == "lies on another edge: one lane for both, with the lower limits"


def test_nodes_in_one_place_are_one_and_need_no_lane() -> None:
    places = dict(SQUARE) | {4: SQUARE[1]}
    zones, report = zones_of(graph_of(places, [(0, 1), (1, 4), (4, 2)]))
    assert [zone.name for zone in zones.zones] == ["p0 - p2"]
    assert texts(report, NO_EFFECT)["edges[1]"].startswith("its ends are less than 0.1 m apart")


def test_stations_have_unique_short_names_and_known_uses() -> None:
    long = "a name that is longer than any name of a zone may be, which has 64"
    stations = [GraphStation(long, (1.0, 2.0), 0.5, ("park", "sing")), GraphStation(long, (3.0, 2.0))]
    zones, _ = zones_of(RouteGraph({}, [], stations, [(1.0, 1.0)]))
    assert [zone.name for zone in zones.stations] == [long[:64], long[:62] + " 2"]
    assert zones.stations[0].rule == Station(name=long[:64], yaw=0.5, uses=["park"])
    assert [zone.name for zone in zones.zones if zone not in zones.stations] == ["places to pass"]


def test_what_a_map_has_no_room_for_is_refused() -> None:
    side = 50
    places = {side * y + x: (2.0 * x, 2.0 * y + 0.3 * (x % 2)) for y in range(side) for x in range(side)}
    rows = [(side * y + x, side * y + x + 1) for y in range(side) for x in range(side - 1)]
    columns = [(side * y, side * y + side) for y in range(side - 1)]
    graph = graph_of(places, both_ways(*rows, *columns))
    graph.stations += [GraphStation(f"s{at}", (0.0, 0.0), part=f"s{at}") for at in range(MOST_MARKS + 3)]
    zones, report = zones_of(graph)
    assert len(zones.stations) == MOST_MARKS
    assert MOST_ON_LANES - 100 < sum(len(zone.geometry.coordinates) for zone in zones.lanes) <= MOST_ON_LANES
    refused = texts(report, REFUSED)
    assert any(
        f"a map may have {MOST_ON_LANES} positions on lanes, and the graph has" in text for text in refused.values()
    )
    assert refused[f"s{MOST_MARKS}, s{MOST_MARKS + 1}, s{MOST_MARKS + 2}"] == f"a map may have {MOST_MARKS} stations"


def test_positions_on_straight_parts_are_left_out_before_lanes_are() -> None:
    count = MOST_ON_LANES + 500
    places = {at: (0.02 * at, 0.0) for at in range(count)}
    zones, report = zones_of(
        graph_of({at: (20.0 * x, y) for at, (x, y) in places.items()}, both_ways(*itertools.pairwise(range(count))))
    )
    assert segments_of(zones) == {((0.0, 0.0), (0.4 * (count - 1), 0.0)), ((0.4 * (count - 1), 0.0), (0.0, 0.0))}
    assert f"{count - 2} on straight parts were left out" in texts(report, TRANSLATED)["positions"]


def test_many_lanes_share_zones_and_groups_have_an_end() -> None:
    places = {at: (float(at % 40), float(at // 40)) for at in range(1600)}
    graph = graph_of(places, [(at, at + 40) for at in range(0, 1560, 2) if (at // 40) % 2 == 0])
    graph.edges += [
        edge
        for at in range(MOST_CAPACITIES + 2)
        for edge in graph_of(places, [(2 * at + 1, 2 * at + 41)], group=f"g{at}").edges
    ]
    zones, report = zones_of(graph)
    assert segments_of(zones) == {(places[int(edge.start)], places[int(edge.end)]) for edge in graph.edges}
    assert len(zones.lanes) <= 300
    [(part, text)] = texts(report, REFUSED).items()
    assert (part.count("group"), text) == (2, f"a map may have {MOST_CAPACITIES} zones of the kind 'capacity'")


@pytest.mark.parametrize("edges", [[], [(0, 1)]])
def test_a_graph_without_stations_has_none(edges: list[tuple[int, int]]) -> None:
    assert zones_of(graph_of(SQUARE, edges))[0].stations == []
