import io

import ezdxf
import pytest

from ppaas.errors import InvalidMap
from ppaas.imports.maps.drawings import dxf
from ppaas.imports.maps.drawings.dxf import draw_dxf
from ppaas.imports.maps.drawings.plan_picture import PlanOptions, ScaleBar
from ppaas.imports.report import ImportOutcome, ImportReport
from tests.support.world.plans import dxf_plan


def drawing(add, unit=6):
    document = ezdxf.new("R2010")
    document.header["$INSUNITS"] = unit
    add(document, document.modelspace())
    text = io.StringIO()
    document.write(text)
    return text.getvalue().encode()


def walls_of(content, **options):
    report = ImportReport("a.dxf")
    drawn = draw_dxf(content, PlanOptions(**options), report)
    return drawn, report


def test_layers_are_walls_doors_or_other_things_by_their_names():
    _, report = walls_of(dxf_plan())
    found = {(entry.part, entry.outcome) for entry in report.entries}
    assert {
        ("layer A-WALL", ImportOutcome.TAKEN), ("layer A-DOOR", ImportOutcome.TRANSLATED),
        ("layer A-ANNO-DIMS", ImportOutcome.NO_EFFECT), ("layer A-WALL", ImportOutcome.NO_EFFECT),
    } <= found  # fmt: skip


def test_layers_may_be_named():
    drawn, report = walls_of(dxf_plan(), layers=("A-DOOR",))
    assert any(entry.part == "layer A-DOOR" and entry.outcome is ImportOutcome.TAKEN for entry in report.entries)
    assert drawn.corner == pytest.approx((4.5, 1.5), abs=0.06)
    with pytest.raises(InvalidMap, match="--layer"):
        walls_of(dxf_plan(), layers=("nothing",))


def test_a_scale_replaces_units_that_are_wrong():
    drawn, report = walls_of(dxf_plan(), scale=ScaleBar((0.0, 0.0), (1.0, 0.0), 0.002))
    assert drawn.greys.shape[1] * drawn.pixel == pytest.approx(2 * 8.0 + 1.0, abs=0.1)
    assert any("--scale-by" in entry.text for entry in report.entries)


def test_curves_and_areas_are_walls_too():
    def add(document, space):
        space.add_lwpolyline([(0, 0), (4, 0), (4, 4)], close=True)
        space.add_ellipse((10, 2), major_axis=(2, 0), ratio=0.5)
        space.add_spline([(0, 8), (2, 9), (4, 8)])
        hatch = space.add_hatch()
        hatch.paths.add_polyline_path([(8, 8), (10, 8), (10, 10), (8, 10)], is_closed=True)

    drawn, report = walls_of(drawing(add))

    def dark(x, y):
        row = drawn.greys.shape[0] - 1 - int((y - drawn.corner[1]) / drawn.pixel)
        column = int((x - drawn.corner[0]) / drawn.pixel)
        return bool((drawn.greys[row - 1 : row + 2, column - 1 : column + 2] == 0).any())

    assert all(dark(*place) for place in ((2, 0), (4, 2), (2, 2), (12, 2), (10, 3), (2, 9), (9, 9)))
    assert not dark(10, 2)
    assert [entry.text for entry in report.entries] == ["a unit is 1 m", "4 entities: walls"]


def test_far_drawings_begin_at_0():
    drawn, report = walls_of(drawing(lambda document, space: space.add_line((4e6, 5e6), (4e6 + 8, 5e6 + 4))))
    assert drawn.corner == pytest.approx((-0.5, -0.5), abs=0.06)
    assert any(entry.part == "origin" for entry in report.entries)


def test_switched_off_layers_have_no_walls():
    def add(document, space):
        document.layers.add("OLD").off()
        space.add_line((0, 0), (5, 0), dxfattribs={"layer": "OLD"})
        space.add_line((0, 0), (0, 5))

    _, report = walls_of(drawing(add))
    assert any(entry.part == "layer OLD" and "switched off" in entry.text for entry in report.entries)


def test_blocks_that_multiply_are_refused(monkeypatch):
    monkeypatch.setattr(dxf, "MOST_ENTITIES", 2000)

    def add(document, space):
        inner = document.blocks.new("B0")
        inner.add_line((0, 0), (1, 0))
        for depth in range(1, 6):
            block = document.blocks.new(f"B{depth}")
            for _ in range(10):
                block.add_blockref(f"B{depth - 1}", (0, 0))
        space.add_blockref("B5", (0, 0))

    with pytest.raises(InvalidMap, match="2000 entities"):
        walls_of(drawing(add))
