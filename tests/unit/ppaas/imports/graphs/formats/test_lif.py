"""Layouts of LIF: read leniently, with what breaks the schema reported."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.imports.graphs.model.route_graph import GraphOptions, GraphStation, points_of
from ppaas.imports.graphs.reading import import_graph, read_graph
from tests.support.graphs import NO_EFFECT, REFUSED, TRANSLATED, layout, lif, lif_edge, lif_node, segments_of, texts

HALL = layout(
    [lif_node("a", 0.0, 0.0), lif_node("b", 5.0, 0.0), lif_node("c", 5.0, 4.0)],
    [lif_edge("a", "b"), lif_edge("b", "a"), lif_edge("b", "c", {"maxSpeed": 0.7})],
)
QUARTER = {
    "degree": 2,
    "knotVector": [0, 0, 0, 1, 1, 1],
    "controlPoints": [{"x": 1, "y": 0}, {"x": 1, "y": 1, "weight": math.sqrt(0.5)}, {"x": 0, "y": 1}],
}
"""A quarter of a circle of 1 m around (0, 0)."""


def test_a_layout_is_lanes_and_zones() -> None:
    zones, report = import_graph(lif(HALL), "hall.lif.json")
    assert segments_of(zones) == {((0.0, 0.0), (5.0, 0.0)), ((5.0, 0.0), (0.0, 0.0)), ((5.0, 0.0), (5.0, 4.0))}
    assert [zone.name for zone in zones.zones] == ["a - b", "b - c", "0.7 m/s"]
    assert texts(report, REFUSED) == {}
    assert not any("breaks the schema" in text for text in texts(report, TRANSLATED).values())


def test_what_breaks_the_schema_is_reported_and_read() -> None:
    odd = json.loads(lif(HALL))
    [hall] = odd["layouts"]
    hall["nodes"][0]["nodePosition"]["x"] = "0.5"
    hall["stations"] = [
        {"stationId": "s", "interactionNodeIds": ["a"], "stationHeight": "0.6", "stationPosition ": {"x": 1, "y": 1}}
    ]
    del hall["layoutVersion"]
    hall["edges"][0]["vehicleTypeEdgeProperties"][0]["orientationType"] = "SIDEWAYS"
    text = json.dumps(odd).replace("]}]}", "],}]}")
    graph, report = read_graph(text.encode(), "hall.lif.json")
    assert graph.nodes["a"].place == (0.5, 0.0)
    assert graph.stations == [GraphStation("s", (0.5, 0.0), None, (), "layouts[0].stations[0]")]
    found = texts(report, TRANSLATED)
    assert (
        found["layouts[0].nodes[0].nodePosition.x, layouts[0].stations[0].stationHeight"]
        == "breaks the schema of LIF: it must be a number"
    )
    assert found["layouts[0].layoutVersion"] == "breaks the schema of LIF: it is missing"
    assert (
        found["layouts[0].stations[0].stationPosition "]
        == "breaks the schema of LIF: no field of LIF; stationPosition is"
    )
    assert (
        "it must be one of GLOBAL, TANGENTIAL"
        in found["layouts[0].edges[0].vehicleTypeEdgeProperties[0].orientationType"]
    )
    assert "trailing commas" in found["file"]


def test_a_field_with_spaces_around_its_name_is_read_and_reported() -> None:
    odd = json.loads(lif(HALL))
    odd["layouts"][0]["edges"][2][" endNodeId "] = odd["layouts"][0]["edges"][2].pop("endNodeId")
    graph, report = read_graph(json.dumps(odd).encode(), "hall.lif.json")
    assert [(edge.start, edge.end) for edge in graph.edges] == [("a", "b"), ("b", "a"), ("b", "c")]
    found = texts(report, TRANSLATED)
    assert found["layouts[0].edges[2]. endNodeId "] == "breaks the schema of LIF: no field of LIF; endNodeId is"
    assert found["layouts[0].edges[2].endNodeId"] == "breaks the schema of LIF: it is missing"


def test_stations_have_headings_and_what_they_are_for() -> None:
    pick = {
        "actions": [{"actionType": "pick", "blockingType": "HARD"}, {"actionType": "beep", "blockingType": "NONE"}],
        "theta": -1.5,
    }
    charger = lif_node("z", 9.0, 0.0, actions=[{"actionType": "startCharging", "blockingType": "HARD"}])
    station = {"stationId": "S1", "stationName": "ramp", "interactionNodeIds": ["b", "c", "gone"]}
    hall = layout(
        [*HALL["nodes"][:1], lif_node("b", 5.0, 0.0, **pick), HALL["nodes"][2], charger], HALL["edges"], [station]
    )
    graph, report = read_graph(lif(hall), "hall")
    assert [(each.name, each.place, each.yaw, each.uses) for each in graph.stations] == [
        ("ramp", (5.0, 0.0), -1.5, ("pick",)),
        ("ramp c", (5.0, 4.0), None, ()),
        ("z", (9.0, 0.0), None, ("charge",)),
    ]
    assert texts(report, REFUSED)["layouts[0].stations[0].interactionNodeIds"] == "no node has the id gone"
    assert "layouts[0].nodes[1] action beep" in texts(report, NO_EFFECT)


def test_the_lowest_limit_of_all_types_of_vehicles_counts_or_that_of_one() -> None:
    edge = lif_edge("a", "b", {"maxSpeed": 1.2}, {"vehicleTypeId": "lift", "maxSpeed": 0.5})
    other = lif_edge("b", "a", {"vehicleTypeId": "lift"})
    content = lif(layout(HALL["nodes"], [edge, other]))
    graph, report = read_graph(content, "hall")
    assert [each.max_speed for each in graph.edges] == [0.5, None]
    assert texts(report, TRANSLATED)["layouts[0].edges[0].maxSpeed"].endswith("the lowest of its types of vehicles")
    graph, report = read_graph(content, "hall", GraphOptions(vehicle="tug"))
    assert [each.max_speed for each in graph.edges] == [1.2]
    assert texts(report, NO_EFFECT)["layouts[0].edges[1]"] == "not for vehicles of the type tug"


def test_curves_are_lanes_with_corners() -> None:
    nodes = [lif_node("a", 1.0, 0.0), lif_node("b", 0.0, 1.0)]
    graph, report = read_graph(lif(layout(nodes, [lif_edge("a", "b", {"trajectory": QUARTER})])), "hall")
    points = np.array(points_of(graph, graph.edges[0]))
    assert np.hypot(*points.T) == pytest.approx(np.ones(len(points)))
    assert 4 <= len(points) < 12
    assert texts(report, TRANSLATED)["layouts[0].edges[0].trajectory"].startswith("a curve")


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"degree": 3}, "degree 3 with 3 control points is no curve"),
        ({"knotVector": [0, 1]}, "3 control points of degree 2 need 6 knots"),
        ({"knotVector": [0, 0, 1, 0, 1, 1]}, "the knots must ascend"),
        ({"knotVector": ["a"] * 6}, "could not convert"),
        ({"controlPoints": [{"x": "?"}] * 3}, "it needs numbers"),
        ({"controlPoints": [{"x": 1, "y": 0, "weight": 0}] * 3}, "weights must be above 0"),
        ({"controlPoints": [{"x": 7, "y": 0}] * 3}, "the curve does not lead from the start to the end"),
    ],
)
def test_curves_that_are_none_are_straight(change: dict[str, object], reason: str) -> None:
    nodes = [lif_node("a", 1.0, 0.0), lif_node("b", 0.0, 1.0)]
    graph, report = read_graph(lif(layout(nodes, [lif_edge("a", "b", {"trajectory": QUARTER | change})])), "hall")
    assert points_of(graph, graph.edges[0]) == [(1.0, 0.0), (0.0, 1.0)]
    assert any(reason in text for text in texts(report, REFUSED).values())


def test_a_layout_is_chosen_and_edges_to_others_are_named() -> None:
    up = layout([lif_node("u", 0.0, 0.0)], [lif_edge("u", "a")], name="up")
    content = lif(HALL, up)
    graph, report = read_graph(content, "hall")
    assert list(graph.nodes) == ["a", "b", "c"]
    assert texts(report, NO_EFFECT)["layouts[1]"] == "up: another floor or part; import it with --level up"
    graph, report = read_graph(content, "hall", GraphOptions(level="up"))
    assert (list(graph.nodes), graph.edges) == (["u"], [])
    assert texts(report, NO_EFFECT)["layouts[1].edges[0]"] == "leads to another layout: robots do not change floors"
    with pytest.raises(InvalidInput, match="hall has no layout 'down': it has hall, up"):
        read_graph(content, "hall", GraphOptions(level="down"))
    with pytest.raises(InvalidInput, match="has no layouts"):
        read_graph(lif(), "hall")


def test_fields_of_the_drafts_of_2_0_are_known() -> None:
    given = {
        "vehicleOrientations": [0.0, 3.14],
        "corridor": {"maximumLeftWidth": 0.2, "maximumRightWidth": 0.2},
        "reachOrientationBeforeEntering": True,
    }
    _, report = read_graph(lif(layout(HALL["nodes"], [lif_edge("a", "b", given)]), version="2.0.0"), "hall")
    assert not any("breaks the schema" in text for text in texts(report, TRANSLATED).values())
    assert any("corridor" in part for part in texts(report, NO_EFFECT))


def of_two(node: str, x: float, *robots: str, **properties: object) -> dict[str, object]:
    """Return a node of LIF 2.0."""
    types = [{"manufacturer": "us", "seriesName": name} for name in robots or ("tug",)]
    own = [{"mobileRobotTypes": types} | properties]
    return {"nodeId": node, "nodePosition": {"x": x, "y": 0.0}, "mobileRobotTypeNodeProperties": own}


def test_names_of_2_0_are_those_before_it() -> None:
    charge = {"actions": [{"actionType": "startCharging", "blockingType": "HARD"}], "theta": 1.0}
    edge = {
        "edgeId": "e", "startNodeId": "a", "endNodeId": "b",
        "mobileRobotTypeEdgeProperties": [
            {"mobileRobotTypes": [{"manufacturer": "us", "seriesName": "tug"}], "maximumSpeed": 0.9,
             "mobileRobotOrientations": [0.0], "physicalLineGuidedProperty": {"direction": "LEFT", "length": 2.0}},
            {"mobileRobotTypes": [{"manufacturer": "us", "seriesName": "lift"}], "maximumSpeed": 0.4},
        ],
    }  # fmt: skip
    hall = {"layoutId": "h", "layoutVersion": "1", "layoutDescriptor": "hall", "edges": [edge]}
    hall["nodes"] = [of_two("a", 0.0, "tug", "lift"), of_two("b", 6.0, "tug", **charge)]
    meta = {"lifId": "x", "creator": "us", "exportTimestamp": "2026-11-01T00:00:00.00Z", "lifVersion": "2.0.0"}
    origins = [{"originId": "O1", "layouts": [hall]}, {"originId": "O2", "layouts": [hall | {"layoutId": "other"}]}]
    content = json.dumps({"metaInformation": meta, "origins": origins}).encode()
    graph, report = read_graph(content, "hall")
    assert [(each.start, each.end, each.max_speed) for each in graph.edges] == [("a", "b", 0.4)]
    assert [(each.name, each.uses, each.yaw) for each in graph.stations] == [("b", ("charge",), 1.0)]
    assert not any("breaks the schema" in text for text in texts(report, TRANSLATED).values())
    assert texts(report, NO_EFFECT)["origins"].startswith("O1, O2: each has its own coordinates")
    assert "layouts[1]" in texts(report, NO_EFFECT)
    graph, _ = read_graph(content, "hall", GraphOptions(vehicle="us.tug"))
    assert [each.max_speed for each in graph.edges] == [0.9]


def test_fields_of_the_release_of_2_0_are_known() -> None:
    deviation = {"aMinimum": 0.3, "bMinimum": 0.2, "aMaximum": 0.5, "bMaximum": 0.4, "theta": 0.0}
    pick = {"actionType": "pick", "blockingType": "HARD", "actionParameters": [{"key": "levels", "value": [1, 2]}]}
    nodes = [of_two("a", 0.0), of_two("b", 5.0, allowedDeviationXY=deviation, feasibleActions=[pick])]
    station = {"stationId": "s", "interactionNodeIds": ["b"], "stationType": "rack"}
    hall = {"layoutId": "h", "layoutVersion": "1", "nodes": nodes, "edges": [], "stations": [station]}
    meta = {"lifId": "x", "creator": "us", "exportTimestamp": "2026-11-01T00:00:00.00Z", "lifVersion": "2.0.0"}
    origins = [{"originId": "O1", "layouts": [hall]}]
    graph, report = read_graph(json.dumps({"metaInformation": meta, "origins": origins}).encode(), "hall")
    assert not any("breaks the schema" in text for text in texts(report, TRANSLATED).values())
    assert [(each.name, each.uses) for each in graph.stations] == [("s", ("pick",))]
    assert "layouts[0].nodes[1].allowedDeviationXY" in texts(report, NO_EFFECT)


def test_a_heading_in_degrees_is_refused() -> None:
    graph, report = read_graph(lif(layout([of_two("a", 0.0, theta=90.0)], [])), "hall")
    assert texts(report, REFUSED)["layouts[0].nodes[0].theta"].startswith("90 is no angle in radians")
    assert list(graph.nodes) == ["a"]


@pytest.mark.parametrize("number", range(10))
def test_the_examples_of_the_format_are_read(data: Path, number: int) -> None:
    file = sorted((data / "lif").glob("*.json"))[number]
    tree = json.loads(file.read_bytes())
    zones, report = import_graph(file.read_bytes(), file.name)
    assert any("breaks the schema" in text for text in texts(report, TRANSLATED).values())
    if "complete" in file.name:  # it has the names of types in the place of values
        assert zones.zones == []
        assert "its nodePosition has no numbers x and y" in texts(report, REFUSED).values()
        return
    [given] = tree["layouts"]
    places = {each["nodeId"]: tuple(each["nodePosition"].values()) for each in given["nodes"]}
    ends = {(places[each["startNodeId"]], places[each["endNodeId"]]) for each in given["edges"]}
    assert segments_of(zones) == {(one, other) for one, other in ends if one != other}
    assert texts(report, REFUSED) == {}
