"""Round trips: lanes, limits and stations are the same after they were written for another program and read again."""

import itertools
import json
from collections.abc import Callable
from pathlib import Path

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.errors import InvalidInput
from ppaas.imports.graphs.formats.lif_file import Layout, lif_file
from ppaas.imports.graphs.formats.nav2_route import nav2_route_file
from ppaas.imports.graphs.from_zones import graph_of_zones
from ppaas.imports.graphs.model.route_graph import GraphStation, RouteGraph, points_of
from ppaas.imports.graphs.reading import import_graph
from ppaas.imports.graphs.to_zones import zones_of_graph
from ppaas.imports.report import ImportReport
from ppaas.zones.shapes import LineString, Point, Polygon
from ppaas.zones.zone import KeepOut, Lane, SpeedZone, Station, Zone, ZoneSet
from tests.support.budget import examples
from tests.support.graphs import NO_EFFECT, REFUSED, SQUARE, TRANSLATED, both_ways, graph_of, segments_of, texts

GRID = {5 * y + x: (2.0 * x, 2.0 * y) for y in range(5) for x in range(5)}
PAIRS = [
    (one, other)
    for one, other in itertools.permutations(GRID, 2)
    if sum(abs(a - b) for a, b in zip(GRID[one], GRID[other], strict=True)) == 2.0
]
STATIONS = st.lists(
    st.builds(
        GraphStation,
        name=st.text("abc", min_size=1, max_size=3),
        place=st.sampled_from(sorted(GRID.values())),
        yaw=st.none() | st.floats(-3.0, 3.0).map(lambda yaw: round(yaw, 3)),
        uses=st.sets(st.sampled_from(["pick", "drop", "charge", "park", "wait", "clean", "dock"])).map(tuple),
    ),
    max_size=4,
    unique_by=(lambda station: station.name, lambda station: station.place),
)
LAYOUT = Layout("hall", "1", "tug", 1.8e9)


def as_nav2(graph: RouteGraph, _report: ImportReport) -> bytes:
    return nav2_route_file(graph, "hall")


def as_lif(graph: RouteGraph, report: ImportReport) -> bytes:
    return lif_file(graph, LAYOUT, report)


def limits_of(zones: ZoneSet) -> dict[tuple[object, object], float | None]:
    """Return the limit of each edge [m/s], by its ends."""
    graph = graph_of_zones(zones, ImportReport("map"))
    return {tuple(points_of(graph, edge)): edge.max_speed for edge in graph.edges}  # type: ignore[misc]


@pytest.mark.parametrize("write", [as_nav2, as_lif])
@settings(max_examples=examples(40))
@given(
    edges=st.sets(st.sampled_from(PAIRS), min_size=1, max_size=30),
    slow=st.sets(st.sampled_from(PAIRS)),
    stations=STATIONS,
)
def test_what_is_written_is_read_as_the_same_zones(
    write: Callable[[RouteGraph, ImportReport], bytes],
    edges: set[tuple[int, int]],
    slow: set[tuple[int, int]],
    stations: list[GraphStation],
) -> None:
    graph = graph_of(GRID, sorted(edges - slow))
    graph.edges += graph_of(GRID, sorted(edges & slow), max_speed=0.4).edges
    used = {GRID[end] for pair in edges for end in pair}
    graph.stations += [station for station in stations if station.place in used]
    zones = zones_of_graph(graph, ImportReport("graph"))
    report = ImportReport("map")
    content = write(graph_of_zones(zones, report), report)
    again, report = import_graph(content, "again")
    assert texts(report, REFUSED) == {}
    assert segments_of(again) == segments_of(zones)
    assert limits_of(again) == limits_of(zones)
    assert sorted(map(_described, again.stations)) == sorted(map(_described, zones.stations))


def _described(zone: Zone) -> tuple[object, ...]:
    assert isinstance(zone.rule, Station)
    return (
        zone.name,
        tuple(zone.geometry.coordinates),
        zone.rule.yaw is None,
        zone.rule.yaw or 0.0,
        sorted(zone.rule.uses),
    )


def map_zones() -> ZoneSet:
    lanes = [
        Zone(LineString([[0.0, 0.0], [10.0, 0.0]]), Lane(name="main")),
        Zone(LineString([[5.0, -3.0], [5.0, 3.0]]), Lane(name="cross", one_way=True)),
    ]
    area = Polygon([[[6.0, -1.0], [12.0, -1.0], [12.0, 1.0], [6.0, 1.0], [6.0, -1.0]]])
    others = [
        Zone(area, SpeedZone(name="slow", percent=40.0)),
        Zone(area, KeepOut(name="stairs")),
        Zone(Point([8.0, 0.3]), Station(name="dock", yaw=1.0, uses=["charge"])),
        Zone(Point([50.0, 0.0]), Station(name="far")),
        Zone(Polygon([[[0.0, 5.0], [1.0, 5.0], [1.0, 6.0], [0.0, 5.0]]]), SpeedZone(name="elsewhere", max_speed=0.2)),
    ]
    return ZoneSet([*lanes, *others])


def test_lanes_that_cross_and_stations_get_nodes() -> None:
    report = ImportReport("hall")
    graph = graph_of_zones(map_zones(), report)
    places = {node.name: node.place for node in graph.nodes.values()}
    assert places["dock"] == (8.0, 0.0)
    assert (5.0, 0.0) in places.values()
    ways = {tuple(points_of(graph, edge)): edge.percent for edge in graph.edges}
    assert ways[(8.0, 0.0), (10.0, 0.0)] == 40.0
    assert ways[(5.0, -3.0), (5.0, 0.0)] is None
    assert ((5.0, 0.0), (5.0, -3.0)) not in ways
    done, nothing = texts(report, TRANSLATED), texts(report, NO_EFFECT)
    assert done["station 'dock'"] == "a node on the nearest lane, 0.30 m beside it"
    assert texts(report, REFUSED) == {"station 'far'": "it is 40.0 m from the nearest lane"}
    assert nothing["keep_out 'stairs'"] == "graphs have no such zones"
    assert nothing["speed_limit 'elsewhere'"] == "no edge is in it"


def test_a_layout_is_valid_by_the_schema_and_names_what_it_lacks(data: Path) -> None:
    report = ImportReport("hall")
    tree = json.loads(lif_file(graph_of_zones(map_zones(), report), LAYOUT, report))
    assert "its limit is a percentage, and LIF has limits in m/s" in texts(report, NO_EFFECT).values()
    assert tree["metaInformation"]["lifVersion"] == "1.0.0"
    assert tree["layouts"][0]["stations"][0]["stationId"] == "dock"
    schema = data.parent / "reference" / "lif" / "lif-2.0-2025-12.schema"
    if not schema.is_file():
        pytest.skip("no real data: set PPAAS_DATA")
    jsonschema.validate(tree, json.loads(schema.read_text()))


def test_a_route_graph_has_what_the_route_server_needs() -> None:
    tree = json.loads(nav2_route_file(graph_of_zones(map_zones(), ImportReport("hall")), "hall"))
    nodes = [each["properties"] for each in tree["features"] if each["geometry"]["type"] == "Point"]
    edges = [each["properties"] for each in tree["features"] if each["geometry"]["type"] == "MultiLineString"]
    ids = [each["id"] for each in (*nodes, *edges)]
    assert ids == list(range(len(ids)))
    assert {each["frame"] for each in nodes} == {"map"}
    assert all({each["startid"], each["endid"]} <= {node["id"] for node in nodes} for each in edges)
    assert {"speed_limit": 40.0} in [each.get("metadata") for each in edges]
    assert {"name": "dock", "uses": ["charge"], "yaw": 1.0} in [each.get("metadata") for each in nodes]


def test_numbers_of_limits_have_a_point() -> None:
    """Nav2 reads a limit as a float, and takes an integer for none."""
    zones = zones_of_graph(graph_of(SQUARE, both_ways((0, 1)), percent=50.0), ImportReport("graph"))
    content = nav2_route_file(graph_of_zones(zones, ImportReport("map")), "map")
    assert b'"speed_limit": 50.0' in content


def test_a_map_without_lanes_has_no_graph() -> None:
    with pytest.raises(InvalidInput, match="the map has no lanes"):
        graph_of_zones(ZoneSet(), ImportReport("map"))
