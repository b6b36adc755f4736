"""Drawings in DXF, written by ezdxf: centre lines of layers, with the unit of the drawing."""

import io
from typing import Any

import ezdxf
import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.imports.graphs.model.route_graph import GraphOptions
from ppaas.imports.graphs.reading import import_graph, read_graph
from tests.support.graphs import NO_EFFECT, REFUSED, TRANSLATED, segments_of, texts


def drawing(unit: int = 6) -> Any:
    document = ezdxf.new("R2010")
    document.units = unit
    return document


def written(document: Any) -> bytes:
    stream = io.StringIO()
    document.write(stream)
    return stream.getvalue().encode()


@pytest.mark.parametrize(("unit", "scale"), [(6, 1.0), (4, 0.001), (5, 0.01), (1, 0.0254), (2, 0.3048)])
def test_lines_of_layers_of_lanes_are_lanes_in_metres(unit: int, scale: float) -> None:
    document, model = drawing(unit), None
    model = document.modelspace()
    model.add_line((0, 0), (10 / scale, 0), {"layer": "AGV-routes"})
    model.add_lwpolyline([(10 / scale, 0), (10 / scale, 5 / scale)], dxfattribs={"layer": "agv one-way"})
    model.add_line((0, 1), (9 / scale, 1), {"layer": "walls"})
    model.add_text("dock", dxfattribs={"layer": "AGV-routes"})
    zones, report = import_graph(written(document), "hall.dxf")
    assert segments_of(zones) == {((0.0, 0.0), (10.0, 0.0)), ((10.0, 0.0), (0.0, 0.0)), ((10.0, 0.0), (10.0, 5.0))}
    assert texts(report, NO_EFFECT)["layer walls"] == "1 lines, not of lanes; --layer walls takes them"
    assert texts(report, NO_EFFECT)["1 TEXT"].startswith("only lines")
    assert f": {scale:g} m" in texts(report, TRANSLATED)["$INSUNITS"]


def test_lines_meet_where_they_cross() -> None:
    document = drawing()
    model = document.modelspace()
    model.add_line((0, 0), (10, 0))
    model.add_line((5, -4), (5, 4))
    zones, report = import_graph(written(document), "cross.dxf")
    assert ((5.0, 0.0), (5.0, 4.0)) in segments_of(zones)
    assert not any("island" in text for entry in report.entries for text in (entry.text,))


def test_arcs_and_blocks_are_flattened() -> None:
    document = drawing()
    block = document.blocks.new("loop")
    block.add_arc((0, 0), 2.0, 0.0, 180.0, dxfattribs={"layer": "lanes"})
    document.modelspace().add_blockref("loop", (10, 0), {"layer": "lanes"})
    graph, _ = read_graph(written(document), "loop.dxf")
    radii = [float(np.hypot(x - 10.0, y)) for x, y in (node.place for node in graph.nodes.values())]
    assert radii == pytest.approx([2.0] * len(radii), abs=0.001)
    assert len(radii) > 6


def test_a_drawing_without_a_unit_is_judged_by_its_size_or_told() -> None:
    for length, scale in ((30.0, 1.0), (30_000.0, 0.001)):
        document = drawing(0)
        document.modelspace().add_line((0, 0), (length, 0))
        zones, report = import_graph(written(document), "hall.dxf")
        assert ((0.0, 0.0), (scale * length, 0.0)) in segments_of(zones)
        assert "the drawing has no known unit" in texts(report, TRANSLATED)["$INSUNITS"]
    zones, _ = import_graph(written(document), "hall.dxf", GraphOptions(scale=0.0001))
    assert ((0.0, 0.0), (3.0, 0.0)) in segments_of(zones)


def test_layers_are_asked_for_unless_one_is_of_lanes() -> None:
    document = drawing()
    model = document.modelspace()
    for layer in ("A1", "A2"):
        model.add_line((0, 0), (3, 0), {"layer": layer})
    content = written(document)
    with pytest.raises(InvalidInput, match=r"--layer NAME; there are A1 \(1 lines\), A2 \(1 lines\)"):
        read_graph(content, "hall.dxf")
    graph, _ = read_graph(content, "hall.dxf", GraphOptions(layers=("a2",)))
    assert len(graph.edges) == 2
    with pytest.raises(InvalidInput, match="no lines on the layer 'b'"):
        read_graph(content, "hall.dxf", GraphOptions(layers=("b",)))


def test_lines_without_a_length_are_refused() -> None:
    document = drawing()
    model = document.modelspace()
    model.add_line((0, 0), (3, 0))
    model.add_line((1, 1), (1, 1))
    _, report = read_graph(written(document), "hall.dxf")
    assert list(texts(report, REFUSED).values()) == ["it has no length"]


def test_files_that_are_no_drawings_are_refused() -> None:
    with pytest.raises(InvalidInput, match="no lines, polylines, arcs or splines"):
        read_graph(written(drawing()), "hall.dxf")
    with pytest.raises(InvalidInput, match=r"no drawing of DXF|no lines"):
        read_graph(b"  0\nSECTION\n  2\nENTITIES\nrubbish\n", "hall.dxf")
