"""Fitting: robots of a radius have room on what is left of a graph."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.fleet.lane_drawing import lines_in, network_of
from ppaas.fleet.lane_placing import placed_on
from ppaas.fleet.lane_roadmap import check_apart
from ppaas.imports.graphs.fitting import fitted, report_room
from ppaas.imports.graphs.model.route_graph import RouteGraph
from ppaas.imports.graphs.to_zones import zones_of_graph
from ppaas.imports.report import ImportReport
from tests.support.budget import examples
from tests.support.graphs import REFUSED, SQUARE, TAKEN, TRANSLATED, both_ways, graph_of, texts

WIDTH = 0.56
"""Width of a cell of robots of 0.18 m."""


def has_room(graph: RouteGraph) -> bool:
    zones = zones_of_graph(graph, ImportReport("graph"))
    if zones.lanes:
        check_apart(placed_on(network_of(lines_in(zones.zones)), WIDTH), WIDTH)
    return True


@settings(max_examples=examples(40))
@given(st.integers(0, 10**6))
def test_any_graph_has_room_after_it(seed: int) -> None:
    random = np.random.default_rng(seed)
    count = int(random.integers(2, 12))
    places = {at: (float(x), float(y)) for at, (x, y) in enumerate(random.uniform(0.0, 8.0, (count, 2)).round(2))}
    pairs = [(int(one), int(other)) for one, other in random.integers(0, count, (2 * count, 2)) if one != other]
    assert has_room(fitted(graph_of(places, pairs), 0.18, ImportReport("graph")))


def test_a_graph_with_room_stays_as_it_is() -> None:
    graph = graph_of(SQUARE, both_ways((0, 1), (1, 2), (2, 3), (3, 0)))
    report = ImportReport("graph")
    assert fitted(graph, 0.18, report) == graph
    assert report.entries == []


def test_nodes_nearby_become_one_and_edges_between_them_end() -> None:
    graph = graph_of(dict(SQUARE) | {4: (4.2, 0.2)}, both_ways((0, 1), (1, 4), (4, 2), (1, 3)))
    report = ImportReport("graph")
    found = fitted(graph, 0.18, report)
    assert {(edge.start, edge.end) for edge in found.edges} == {
        ("0", "1"),
        ("1", "0"),
        ("1", "2"),
        ("2", "1"),
        ("1", "3"),
        ("3", "1"),
    }
    assert (
        texts(report, TRANSLATED)["nodes[4]"]
        == "joined with a node nearby: robots of this radius need 0.56 m between two nodes"
    )


def test_edges_too_near_to_others_are_left_out_with_the_reason() -> None:
    places = {0: (0.0, 0.0), 1: (9.0, 0.0), 2: (1.0, 0.3), 3: (7.0, 0.3)}
    report = ImportReport("graph")
    found = fitted(graph_of(places, both_ways((0, 1), (2, 3))), 0.18, report)
    assert {(edge.start, edge.end) for edge in found.edges} == {("0", "1"), ("1", "0")}
    [(part, text)] = texts(report, REFUSED).items()
    assert part == "edges[2], edges[3]"
    assert text.startswith("left out: lanes 'p0 - p1' and 'p2 - p3' are 0.30 m apart near")


def test_a_report_names_the_first_place_without_room() -> None:
    report = ImportReport("graph")
    places = {0: (0.0, 0.0), 1: (9.0, 0.0), 2: (1.0, 0.3), 3: (7.0, 0.3)}
    report_room(graph_of(places, both_ways((0, 1), (2, 3))), report)
    [text] = texts(report, TAKEN).values()
    assert text.startswith("robots with a radius of 0.2 m have no room: lanes 'p0 - p1' and 'p2 - p3' are 0.30 m apart")
    report = ImportReport("graph")
    report_room(graph_of(SQUARE, both_ways((0, 1), (1, 2), (2, 3), (3, 0))), report)
    assert report.entries == []


def test_lanes_that_are_too_long_for_robots_are_reported() -> None:
    places = {0: (0.0, 0.0), 1: (90_000.0, 0.0)}
    for say in (report_room, lambda graph, report: fitted(graph, 0.18, report)):
        report = ImportReport("graph")
        say(graph_of(places, both_ways((0, 1))), report)
        assert any("the lanes are 90000 m long" in entry.text for entry in report.entries)


@pytest.mark.parametrize("count", [5, 7])
def test_of_many_lanes_that_meet_four_are_kept(count: int) -> None:
    places = {at: (3.0 * math.cos(at), 3.0 * math.sin(at)) for at in range(count)} | {count: (0.0, 0.0)}
    found = fitted(graph_of(places, both_ways(*((count, at) for at in range(count)))), 0.18, ImportReport("graph"))
    assert len(found.edges) == 8
