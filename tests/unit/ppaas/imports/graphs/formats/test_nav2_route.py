"""Route graphs of Nav2: read as its route server reads them, and leniently where it would fail."""

import json
from pathlib import Path
from typing import Any

import pytest

from ppaas.errors import InvalidInput
from ppaas.imports.graphs.model.route_graph import GraphOptions, GraphStation
from ppaas.imports.graphs.reading import import_graph, read_graph
from tests.support.graphs import NO_EFFECT, REFUSED, TAKEN, TRANSLATED, edge, node, route_graph, segments_of, texts

TWO = node(0, (0.0, 0.0)), node(1, (3.0, 4.0))


def limits(**metadata: Any) -> tuple[float | None, float | None, Any]:
    graph, report = read_graph(route_graph(*TWO, edge(2, 0, 1, metadata=metadata)), "graph.geojson")
    return graph.edges[0].max_speed, graph.edges[0].percent, report


def test_edges_are_straight_and_one_way() -> None:
    there, back = edge(2, 0, 1), edge(3, 1, 0)
    curved = json.loads(json.dumps(there))
    curved["geometry"] = {"type": "LineString", "coordinates": [[0, 0], [0, 4], [3, 4]]}
    zones, report = import_graph(route_graph(*TWO, curved), "graph.geojson")
    assert segments_of(zones) == {((0.0, 0.0), (3.0, 4.0))}
    assert (
        texts(report, NO_EFFECT)["features[2].geometry"]
        == "positions between its nodes: as in Nav2, an edge is straight"
    )
    zones, _ = import_graph(route_graph(*TWO, there, back), "graph.geojson")
    assert [zone.rule.__struct_config__.tag for zone in zones.zones] == ["lane"]
    assert len(segments_of(zones)) == 2


def test_limits_are_parts_percentages_or_metres_by_second() -> None:
    assert limits(speed_limit=0.85)[:2] == (None, 85.0)
    assert limits(speed_limit=40)[:2] == (None, 40.0)
    assert limits(abs_speed_limit=0.3)[:2] == (0.3, None)
    assert limits(speed_limit=100.0)[:2] == (None, None)
    assert limits(speed_limit="fast", abs_speed_limit=-1)[:2] == (None, None)
    report = limits(speed_limit=0.85, aisle=7)[2]
    assert "as Nav2's DistanceScorer reads it: 85 %" in texts(report, TRANSLATED)["features[2].metadata.speed_limit"]
    assert "features[2].metadata.aisle" in texts(report, NO_EFFECT)


def test_costs_operations_and_frames_are_reported() -> None:
    odd = node(2, (6.0, 4.0), frame="odom", operations={"stop": {"type": "stop", "trigger": "NODE"}})
    door = [{"type": "open_door", "trigger": "ON_ENTER"}]
    graph, report = read_graph(route_graph(*TWO, odd, edge(5, 0, 1, cost=3, overridable=False, operations=door)), "g")
    assert len(graph.edges) == 1
    nothing = texts(report, NO_EFFECT)
    assert nothing["features[3].cost, features[3].overridable"].startswith("robots take the shortest way")
    assert "features[2].operations.stop, features[3].operations.open_door" in nothing
    assert texts(report, TRANSLATED)["features[2]"].startswith("frame 'odom' was taken as that of the map")


def test_named_nodes_are_stations() -> None:
    graph, _ = read_graph(
        route_graph(
            node(0, (1.0, 2.0), metadata={"name": "dock", "uses": ["charge"], "yaw": 1}), TWO[1], edge(2, 0, 1)
        ),
        "g",
    )
    assert graph.stations == [GraphStation("dock", (1.0, 2.0), 1.0, ("charge",), "features[0]")]


def test_wrong_features_are_refused_and_the_rest_is_taken() -> None:
    features = [
        *TWO,
        node(1, (9.0, 9.0)),
        node(None, (0.0, 1.0)),
        node(7, ("x", 1.0)),
        edge(2, 0, 1),
        edge(2, 1, 0),
        edge(3, 0, 8),
        edge(4, 1, 1),
        "text",
        {"type": "Feature", "geometry": {"type": "Polygon"}},
    ]
    graph, report = read_graph(route_graph(*features), "g")
    assert [(each.start, each.end) for each in graph.edges] == [("0", "1"), ("1", "0")]
    refused = texts(report, REFUSED)
    assert refused["features[2]"] == "its id is that of features[1]: the first one counts; give it another id"
    assert refused["features[3]"] == "this node has no id"
    assert refused["features[4]"] == "this node has no coordinates x, y"
    assert refused["features[7]"] == "no node has the id 8"
    assert refused["features[8]"] == "it leads from a node to itself"
    assert refused["features[9]"] == "a feature without a geometry is no node and no edge"
    assert refused["features[10]"] == "a Polygon is no node and no edge"
    assert texts(report, TRANSLATED)["features[6]"] == "id 2 is that of another edge, too; both were taken"


@pytest.mark.parametrize("geometry", [None, 1, {"type": {}}, {"type": ["Point"], "coordinates": 1}, {"type": "Point"}])
def test_features_with_odd_geometries_are_refused(geometry: object) -> None:
    odd = {"type": "Feature", "geometry": geometry, "properties": [1]}
    graph, report = read_graph(route_graph(*TWO, edge(2, 0, 1), odd), "g")
    assert len(graph.edges) == 1
    assert list(texts(report, REFUSED)) == ["features[3]"]


def test_names_of_the_first_versions_are_known() -> None:
    old = {
        "type": "Feature",
        "properties": {"edge_id": 7, "start_node": 0, "end_node": 1},
        "geometry": {"type": "MultiLineString"},
    }
    graph, report = read_graph(route_graph(*TWO, old), "g")
    assert [(each.name, each.start, each.end) for each in graph.edges] == [("edge 7", "0", "1")]
    assert report.counts()["no effect"] == 0


def test_edges_without_ids_end_at_the_nodes_nearby() -> None:
    drawn = {
        "type": "Feature",
        "properties": {},
        "geometry": {"type": "LineString", "coordinates": [[0.02, 0], [3, 4.05]]},
    }
    away = {"type": "Feature", "properties": {}, "geometry": {"type": "LineString", "coordinates": [[0, 0], [3, 5]]}}
    graph, report = read_graph(route_graph(*TWO, drawn, away), "g")
    assert [(each.start, each.end) for each in graph.edges] == [("0", "1")]
    assert texts(report, REFUSED)["features[3]"] == "this edge has no 'startid' and 'endid', and ends at no node"


def test_degrees_need_an_anchor() -> None:
    places = [(13.4, 52.5), (13.4001, 52.5), (13.4001, 52.5001)]
    content = route_graph(*(node(at, place) for at, place in enumerate(places)), edge(3, 0, 1), edge(4, 1, 2))
    with pytest.raises(InvalidInput, match="--anchor LATITUDE LONGITUDE"):
        read_graph(content, "graph.geojson")
    graph, report = read_graph(content, "graph.geojson", GraphOptions(anchor=(52.5, 13.4)))
    assert graph.nodes["0"].place == pytest.approx((0.0, 0.0), abs=1e-6)
    assert graph.nodes["2"].place == pytest.approx((6.79, 11.13), abs=0.01)
    assert "positions" in texts(report, TRANSLATED)


def test_the_real_graph_of_a_warehouse_is_taken_as_a_whole(data: Path) -> None:
    content = (data / "foreign" / "nav2_wh.geojson").read_bytes()
    zones, report = import_graph(content, "nav2_wh.geojson")
    tree = json.loads(content)
    places = {
        each["properties"]["id"]: tuple(each["geometry"]["coordinates"])
        for each in tree["features"]
        if each["geometry"]["type"] == "Point"
    }
    ends = [each["properties"] for each in tree["features"] if "startid" in each["properties"]]
    assert segments_of(zones) == {(places[each["startid"]], places[each["endid"]]) for each in ends}
    assert report.counts()["refused"] == 0
    assert texts(report, TAKEN)["96 nodes"] == "ends and corners of lanes"
