"""Drawings in DXF, whole and damaged, and their units."""

import io

import ezdxf
import pytest
from ezdxf import units

from ppaas.errors import InvalidInput
from ppaas.imports.drawing_file import UNITS, read_drawing, unit_code
from ppaas.imports.plain_entities import PlainEntity


def drawing(unit: int = 4) -> ezdxf.document.Drawing:
    document = ezdxf.new("R2010")
    document.header["$INSUNITS"] = unit
    document.modelspace().add_line((0, 0), (1, 0))
    return document


def text_of(document: ezdxf.document.Drawing) -> bytes:
    stream = io.StringIO()
    document.write(stream)
    return stream.getvalue().encode()


def binary_of(document: ezdxf.document.Drawing) -> bytes:
    stream = io.BytesIO()
    document.write(stream, fmt="bin")
    return stream.getvalue()


@pytest.mark.parametrize("written", [text_of, binary_of])
def test_text_and_binary_drawings_are_read(written) -> None:
    document = drawing()
    document.modelspace().add_circle((0, 0), 1.0)
    document.modelspace().add_line((0, 0), (2, 0))
    found = read_drawing(written(document), "hall.dxf", "graphs")
    kinds = [each.kind if isinstance(each, PlainEntity) else each.dxftype() for each in found.entities()]
    assert kinds == ["LINE", "CIRCLE", "LINE"]
    assert (unit_code(found.document), found.faults) == (4, 0)


@pytest.mark.parametrize("content", [b"\x00\x01", b"no drawing"])
def test_what_is_no_drawing_is_refused(content: bytes) -> None:
    with pytest.raises(InvalidInput, match=r"hall.dxf is no drawing of DXF"):
        read_drawing(content, "hall.dxf", "graphs")


@pytest.mark.parametrize("content", [b"0\nSECTION\n", b"0\nSECTION\n2\nHEADER\n"])
def test_a_drawing_that_ends_early_is_empty(content: bytes) -> None:
    assert list(read_drawing(content, "hall.dxf", "graphs").entities()) == []


@pytest.mark.parametrize("code", [1, 2, 3, 4, 5, 6, 7, 10, 14])
def test_units_are_those_of_the_format(code: int) -> None:
    metres = units.conversion_factor(units.InsertUnits(code), units.InsertUnits.Meters)
    assert metres == pytest.approx(UNITS[code], rel=1e-5)


def test_a_unit_that_the_format_does_not_have_is_none() -> None:
    assert unit_code(drawing(99)) not in UNITS
