"""Reading of graphs: the format is found by the content, and what cannot be read is refused with the reason."""

import codecs
import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.imports.graphs import reading
from ppaas.imports.graphs.model.route_graph import GraphOptions
from ppaas.imports.graphs.reading import import_graph, read_graph
from ppaas.maps.grid import GridInfo
from tests.support.graphs import REFUSED, edge, layout, lif, lif_edge, lif_node, node, route_graph, segments_of, texts

GRAPH = route_graph(node(0, (0, 0)), node(1, (4, 0)), node(2, (4, 3)), edge(3, 0, 1), edge(4, 1, 2))


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-32"])
def test_any_encoding_of_unicode_is_read(encoding: str) -> None:
    assert len(read_graph(GRAPH.decode().encode(encoding), "g").graph.edges) == 2


def test_what_is_off_the_map_is_left_out() -> None:
    info = GridInfo(0.05, 200, 40, Pose2D(-1.0, -1.0, 0.0))
    zones, report = import_graph(GRAPH, "g", info=info)
    assert segments_of(zones) == {((0.0, 0.0), (4.0, 0.0))}
    refused = texts(report, REFUSED)
    assert refused["features[2]"].startswith("outside of the map, which is at -1 to 9 m × -1 to 1 m")
    assert refused["features[4]"] == "its node was refused"


def test_curves_and_stations_off_the_map_are_left_out() -> None:
    curve = {
        "trajectory": {
            "degree": 1,
            "knotVector": [0, 0, 0.5, 1, 1],
            "controlPoints": [{"x": 0, "y": 0}, {"x": 2, "y": 9}, {"x": 4, "y": 0}],
        }
    }
    hall = layout(
        [lif_node("a", 0, 0), lif_node("b", 4, 0), lif_node("c", 4, 8)],
        [lif_edge("a", "b", curve)],
        [{"stationId": "s", "interactionNodeIds": ["c"]}],
    )
    zones, report = import_graph(lif(hall), "hall", info=GridInfo(0.05, 200, 40, Pose2D(-1.0, -1.0, 0.0)))
    assert zones.zones == []
    assert texts(report, REFUSED)["layouts[0].edges[0]"] == "a part of its curve is outside of the map"
    assert "layouts[0].stations[0]" in " ".join(texts(report, REFUSED))


def test_a_graph_is_moved_into_the_frame_of_the_map() -> None:
    zones, _ = import_graph(GRAPH, "g", GraphOptions(shift=(10.0, 20.0, 1.5707963267948966)))
    assert segments_of(zones) == {((10.0, 20.0), (10.0, 24.0)), ((10.0, 24.0), (7.0, 24.0))}


def test_places_too_far_away_are_refused() -> None:
    far = route_graph(node(0, (390000.0, 5820000.0)), node(1, (390004.0, 5820000.0)), edge(2, 0, 1))
    zones, report = import_graph(far, "g")
    assert zones.zones == []
    assert texts(report, REFUSED)["features[0], features[1]"].endswith("give the offset with --shift")
    zones, _ = import_graph(far, "g", GraphOptions(shift=(-390000.0, -5820000.0, 0.0)))
    assert segments_of(zones) == {((0.0, 0.0), (4.0, 0.0))}


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "g is empty"),
        (codecs.BOM_UTF8 + b" \n", "g is empty"),
        (b"{", "no JSON: .* in line 1"),
        (b'{"a": 1}', "is JSON, but no graph: this takes a route graph of Nav2"),
        (b"[" * 100_000, "is nested more than 64 deep, in line 1"),
        (b"levels:\n  - " + b"- " * 100_000, "is nested more than 64 deep, in line 2"),
        (b'{"a":' * 100_000, "nested too deeply"),
        (b'{"features": [\xff]}', "no text in UTF-8"),
        (b"\x89PNG\r\n\x1a\n" + bytes(64), "is no YAML"),
        (b"just text", "YAML, but no mapping"),
    ],
)
def test_what_cannot_be_read_is_refused_with_the_reason(content: bytes, reason: str) -> None:
    with pytest.raises(InvalidInput, match=reason):
        read_graph(content, "g")


def test_a_file_named_json_is_read_as_json() -> None:
    with pytest.raises(InvalidInput, match=r"graph\.geojson is no JSON: .* in line 1"):
        read_graph(b'// routes\n{"type": "FeatureCollection"}', "graph.geojson")


def test_files_that_are_too_large_are_refused_unread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reading, "MAX_FILE", 100)
    with pytest.raises(InvalidInput, match=f"g has {len(GRAPH)} bytes; at most 100 are allowed"):
        read_graph(GRAPH, "g")


VALUES = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers(-9, 9) | st.text(max_size=3),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(
                ["id", "type", "properties", "geometry", "coordinates", "nodes", "edges", "x", "trajectory"]
            ),
            inner,
            max_size=4,
        )
    ),
    max_leaves=12,
)


@given(st.lists(VALUES, max_size=4), st.lists(VALUES, max_size=3))
def test_any_content_of_features_and_layouts_is_read_or_refused(features: list[object], layouts: list[object]) -> None:
    import json

    for tree in (
        {"features": [node(0, (0, 0)), edge(1, 0, 0), *features]},
        {"layouts": [layout(features, layouts, features)]},
        {"layouts": layouts},
    ):
        with contextlib.suppress(InvalidInput):
            import_graph(json.dumps(tree).encode(), "g")
