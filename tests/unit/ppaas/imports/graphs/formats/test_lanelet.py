"""Maps of Lanelet2: centre lines between borders, joined where lanelets share the ends of these."""

import pytest

from ppaas.errors import InvalidInput
from ppaas.imports.graphs.model.route_graph import GraphOptions, points_of
from ppaas.imports.graphs.reading import import_graph, read_graph
from tests.support.graphs import NO_EFFECT, REFUSED, TRANSLATED, segments_of, texts

NODES = {1: (0, 1), 2: (10, 1), 3: (20, 1), 4: (0, -1), 5: (10, -1), 6: (20, -1)}


def osm(*relations: str, local: bool = True, ways: str = "") -> bytes:
    nodes = ""
    for key, (x, y) in NODES.items():
        tags = f'<tag k="local_x" v="{x}"/><tag k="local_y" v="{y}"/>' if local else ""
        nodes += f'<node id="{key}" lat="{48 + y * 9e-6:.7f}" lon="{8 + x * 1.34e-5:.7f}">{tags}</node>'
    ends = {10: (1, 2), 11: (2, 3), 12: (5, 4), 13: (5, 6)}
    lines = "".join(f'<way id="{key}"><nd ref="{a}"/><nd ref="{b}"/></way>' for key, (a, b) in ends.items())
    return f'<?xml version="1.0"?><osm version="0.6">{nodes}{lines}{ways}{"".join(relations)}</osm>'.encode()


def lanelet(key: int, left: int, right: int, **tags: str) -> str:
    given = {"type": "lanelet", "subtype": "road"} | tags
    members = f'<member type="way" ref="{left}" role="left"/><member type="way" ref="{right}" role="right"/>'
    drawn = "".join(f'<tag k="{name}" v="{value}"/>' for name, value in given.items())
    return f'<relation id="{key}">{members}{drawn}</relation>'


def test_lanelets_are_lanes_in_their_direction() -> None:
    zones, report = import_graph(
        osm(lanelet(20, 10, 12, speed_limit="3.6 km/h"), lanelet(21, 11, 13, one_way="no", location="urban")),
        "hall.osm",
    )
    assert segments_of(zones) == {((0.0, 0.0), (10.0, 0.0)), ((10.0, 0.0), (20.0, 0.0)), ((20.0, 0.0), (10.0, 0.0))}
    assert texts(report, TRANSLATED)["relation 20.speed_limit"] == "a zone that limits the speed to 1 m/s"
    assert "relation 21.location" in texts(report, NO_EFFECT)


def test_swapped_borders_lead_the_other_way() -> None:
    graph, _ = read_graph(osm(lanelet(20, 12, 10)), "hall.osm")
    assert points_of(graph, graph.edges[0]) == [(10.0, 0.0), (0.0, 0.0)]


def test_a_given_centre_line_is_taken() -> None:
    extra = '<node id="7" lat="0" lon="0"><tag k="local_x" v="5"/><tag k="local_y" v="0.5"/></node>'
    way = '<way id="14"><nd ref="1"/><nd ref="7"/><nd ref="2"/></way>'
    relation = lanelet(20, 10, 12).replace("<tag", '<member type="way" ref="14" role="centerline"/><tag', 1)
    graph, _ = read_graph(osm(relation, ways=extra + way), "hall.osm")
    assert points_of(graph, graph.edges[0]) == [(0.0, 0.0), (5.0, 0.5), (10.0, 0.0)]


def test_degrees_need_an_anchor() -> None:
    with pytest.raises(InvalidInput, match="--anchor LATITUDE LONGITUDE"):
        read_graph(osm(lanelet(20, 10, 12), local=False), "hall.osm")
    graph, _ = read_graph(osm(lanelet(20, 10, 12), local=False), "hall.osm", GraphOptions(anchor=(48.0, 8.0)))
    assert points_of(graph, graph.edges[0])[1] == pytest.approx((10.0, 0.0), abs=0.02)


def test_a_way_that_is_called_a_lanelet_is_refused() -> None:
    way = '<way id="14"><nd ref="1"/><nd ref="2"/><tag k="type" v="lanelet"/></way>'
    _, report = read_graph(osm(ways=way), "hall.osm")
    assert texts(report, REFUSED) == {"way 14": "a lanelet is a relation of two borders, no way"}
    assert not [entry for entry in report.entries if "ends of lanelets" in entry.part]


def test_what_is_no_lane_is_reported() -> None:
    relations = (
        lanelet(20, 10, 12, subtype="crosswalk"),
        lanelet(21, 10, 99),
        lanelet(22, 10, 12, speed_limit="walk"),
        '<relation id="23"><tag k="type" v="regulatory_element"/></relation>',
    )
    graph, report = read_graph(osm(*relations), "hall.osm")
    assert [edge.name for edge in graph.edges] == ["lanelet 22"]
    assert texts(report, NO_EFFECT)["relation 20"] == "a lanelet for others: crosswalk"
    assert texts(report, REFUSED) == {
        "relation 21": "a lanelet needs a left and a right border with two nodes or more",
        "relation 22.speed_limit": "'walk' is no speed in km/h, mph or m/s",
    }
    assert "relation 23 regulatory_element" in texts(report, NO_EFFECT)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"<osm><node", "no XML that can be read"),
        (b"<kml></kml>", "XML of kml, not of OSM"),
        (b"<osm></osm>", "no nodes with positions"),
        (
            b'<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]><osm>&b;</osm>',
            "no XML that can be read",
        ),
    ],
)
def test_files_that_are_no_maps_of_lanelets_are_refused(content: bytes, reason: str) -> None:
    with pytest.raises(InvalidInput, match=reason):
        read_graph(content, "hall.osm")
