"""Plain entities of drawings: the same positions as by ezdxf, and all others left to it."""

import io
from typing import Any

import ezdxf
import numpy as np
import pytest
from ezdxf.path import make_path

from ppaas.imports.drawing_file import read_drawing
from ppaas.imports.plain_entities import PlainEntity, split_drawing

HEAD, END = "0\nSECTION\n2\nENTITIES\n", "0\nENDSEC\n0\nEOF\n"
PAPER, OTHER = " 67\n1\n", "410\nA\n"
LINE = "  0\nLINE\n  8\nhall\n 10\n0\n 20\n0\n 11\n2\n 21\n1\n"


def written(document: Any) -> bytes:
    stream = io.StringIO()
    document.write(stream)
    return stream.getvalue().encode()


def corners(entity: Any) -> list[list[float]]:
    if isinstance(entity, PlainEntity):
        return entity.points.tolist()
    return [[at.x, at.y] for at in make_path(entity).flattening(0.01)]


@pytest.mark.parametrize("version", ["R12", "R2000", "R2018"])
def test_positions_layers_and_order_are_those_of_ezdxf(version: str) -> None:
    rng = np.random.default_rng(1)
    document = ezdxf.new(version)
    model = document.modelspace()
    for number in range(40):
        about = {"layer": f"layer {number % 3}"}
        points = rng.uniform(-50.0, 50.0, (4, 2)).tolist()
        model.add_line(*points[:2], dxfattribs=about)
        model.add_circle(points[0], 1.0, dxfattribs=about)
        if version != "R12":
            model.add_lwpolyline(points, close=bool(number % 2), dxfattribs=about)
            model.add_lwpolyline(points, "xyb", dxfattribs=about)
            model.add_lwpolyline([(*point, 0.0, 0.0, 0.5) for point in points], dxfattribs=about)
    content = written(document)
    whole = ezdxf.read(io.StringIO(content.decode())).modelspace()
    found = list(read_drawing(content, "hall.dxf", "graphs").entities())
    assert sum(isinstance(each, PlainEntity) for each in found) == (40 if version == "R12" else 120)
    for one, other in zip(found, whole, strict=True):
        layer, handle = (one.layer, one.handle) if isinstance(one, PlainEntity) else (one.dxf.layer, one.dxf.handle)
        assert (layer, handle) == (other.dxf.layer, other.dxf.handle)
        np.testing.assert_allclose(corners(one), corners(other))


def test_what_is_turned_or_on_paper_is_left_to_ezdxf() -> None:
    document = ezdxf.new("R2010")
    document.modelspace().add_line((0, 0), (1, 0), dxfattribs={"extrusion": (0, 0, -1)})
    document.modelspace().add_lwpolyline([(0, 0), (1, 0)], dxfattribs={"extrusion": (0, 0, -1)})
    document.layout("Layout1").add_line((0, 0), (5, 0))
    found = read_drawing(written(document), "hall.dxf", "graphs")
    assert found.plain == []
    assert [each.dxftype() for each in found.entities()] == ["LINE", "LWPOLYLINE"]


def test_texts_have_no_corners() -> None:
    document = ezdxf.new("R2010")
    document.modelspace().add_mtext("LINE", dxfattribs={"layer": "notes"})
    [text] = read_drawing(written(document), "hall.dxf", "graphs").plain
    assert (text.kind, text.layer, len(text.points)) == ("MTEXT", "notes", 0)


def test_a_line_of_a_file_without_handles_is_plain() -> None:
    rest, [line], numbers = split_drawing(HEAD + LINE + END)
    assert (line.layer, line.handle, line.points.tolist()) == ("hall", "", [[0.0, 0.0], [2.0, 1.0]])
    assert (rest, numbers) == (HEAD + END, {})


@pytest.mark.parametrize(
    "line", [LINE.replace(" 11\n2\n", ""), LINE + " 10\n3\n", LINE + " 67\n1\n", LINE + "410\nA\n"]
)
def test_a_line_with_missing_or_other_tags_is_not_plain(line: str) -> None:
    assert split_drawing(HEAD + line + END).plain == []


@pytest.mark.parametrize("text", ["", "0\nSECTION", HEAD + LINE, HEAD + LINE.replace("2\n", "x\n") + END, "a\nb\n"])
def test_a_text_that_is_no_whole_drawing_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r".+"):
        split_drawing(text)


def test_a_drawing_without_entities_stays_as_it_is() -> None:
    text = "0\nSECTION\n2\nHEADER\n0\nENDSEC\n0\nEOF\n"
    assert split_drawing(text) == (text, [], {})
