"""Connectivity: islands and one-way traps are found by brute force alike."""

from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.imports.graphs.connectivity import connections_of, report_connections, report_crossings
from ppaas.imports.report import ImportReport
from tests.support.budget import examples
from tests.support.graphs import SQUARE, both_ways, graph_of

EDGES = st.lists(st.tuples(st.integers(0, 7), st.integers(0, 7)).filter(lambda pair: pair[0] != pair[1]), max_size=14)
PLACES = {key: (float(key), 0.0) for key in range(8)}


def reached(edges: list[tuple[int, int]], start: int) -> set[int]:
    found, waiting = {start}, [start]
    while waiting:
        here = waiting.pop()
        for one, other in edges:
            if one == here and other not in found:
                found.add(other)
                waiting.append(other)
    return found


@settings(max_examples=examples(200))
@given(EDGES)
def test_nodes_of_the_core_reach_each_other_and_all_others_are_named(edges: list[tuple[int, int]]) -> None:
    found = connections_of(graph_of(PLACES, edges))
    both = [*edges, *((other, one) for one, other in edges)]
    used = {end for pair in edges for end in pair}
    assert set(map(int, found.lonely)) == set(PLACES) - used
    apart = {int(key) for island in found.islands for key in island}
    largest = used - apart
    sizes = {len(reached(both, key)) for key in used}
    assert len(largest) == max(sizes, default=0)
    traps, sources = set(map(int, found.no_way_out)), set(map(int, found.no_way_in))
    core = largest - traps - sources
    for one in core:
        ways = reached(edges, one)
        assert core <= ways
        assert not sources & ways
    for trap in traps:
        assert not core & reached(edges, trap)
    for source in sources:
        assert core <= reached(edges, source)


def test_a_report_names_traps_and_islands() -> None:
    places = dict(SQUARE) | {4: (9.0, 0.0), 5: (20.0, 0.0), 6: (21.0, 0.0), 7: (30.0, 0.0)}
    graph = graph_of(places, [*both_ways((0, 1), (1, 2), (2, 3), (5, 6)), (1, 4)])
    report = ImportReport("graph")
    report_connections(graph, report)
    found = {entry.part: entry.text for entry in report.entries}
    assert found["node p4"].startswith("one-way trap: robots get here and not back")
    assert found["nodes p5, p6"].startswith("island: no edge connects these 2 nodes")
    assert found["node p7"] == "no edge leads here; only lanes are driven along"
    assert len(found) == 3


def test_crossings_without_a_node_are_named() -> None:
    report = ImportReport("graph")
    report_crossings(graph_of(SQUARE, both_ways((0, 2), (1, 3), (0, 1))), report)
    [entry] = report.entries
    assert entry.part == "edges[1] and edges[3]"
    assert entry.text == "they cross without a node: robots may turn from one into the other there"
    report = ImportReport("graph")
    report_crossings(graph_of(SQUARE, both_ways((0, 1), (1, 2), (2, 3))), report)
    assert report.entries == []
