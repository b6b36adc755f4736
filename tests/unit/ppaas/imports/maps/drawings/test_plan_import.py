import numpy as np
import pytest

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.imports.maps.drawings import plan_import
from ppaas.imports.maps.drawings.plan_import import import_plan
from ppaas.imports.maps.drawings.plan_picture import PlanOptions, ScaleBar
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN
from tests.support.world.plans import PIXEL, dxf_plan, picture_plan, svg_plan

BY_PIXELS = ScaleBar((50.0, 50.0), (450.0, 50.0), 400 * PIXEL)
BY_UNITS = ScaleBar((100.0, 100.0), (900.0, 100.0), 8.0)
PLANS = {
    "plan.png": (picture_plan(), BY_PIXELS),
    "plan.jpg": (picture_plan("JPEG"), BY_PIXELS),
    "plan.bmp": (picture_plan("BMP"), BY_PIXELS),
    "plan.pdf": (picture_plan("PDF"), BY_PIXELS),
    "plan.svg": (svg_plan(), BY_UNITS),
    "plan.dxf": (dxf_plan(), None),
    "binary.dxf": (dxf_plan(binary=True), None),
    "unitless.dxf": (dxf_plan(unit=0), ScaleBar((1000.0, 1000.0), (9000.0, 1000.0), 8.0)),
}


@pytest.mark.parametrize("name", PLANS)
def test_walls_enclose_two_rooms_with_a_door(name):
    content, scale = PLANS[name]
    imported, report, drawn = import_plan(content, name, PlanOptions(scale=scale))
    grid = imported.grid

    def at(x, y):
        return int(grid.data[grid.info.cell_of(x, y)])

    assert [at(1.5, 2.5), at(5.0, 2.5), at(8.5, 2.5)] == [FREE] * 3
    # Lines of DXF are one cell wide: look at the cells around them, too.
    walls = [(1.0, 2.5), (9.0, 2.5), (5.0, 1.5), (5.0, 3.5), (3.0, 1.0), (3.0, 4.0)]
    assert all(max(at(x + dx, y + dy) for dx in (-0.04, 0.0) for dy in (-0.04, 0.0)) == OCCUPIED for x, y in walls)
    assert at(0.7, 2.5) == UNKNOWN
    assert (grid.data == FREE).sum() * 0.05**2 == pytest.approx(24.0, abs=2.5)
    assert drawn.greys.dtype == np.uint8
    assert {"walls", "free space", "grid"} <= {entry.part for entry in report.entries}


def test_a_start_chooses_the_room_and_the_outside_may_be_free():
    walls = svg_plan('<path d="M500 200V300" stroke="black" stroke-width="5"/>')
    options = {"scale": BY_UNITS}
    one, _, _ = import_plan(walls, "a.svg", PlanOptions(start=(2.0, 2.5), **options))
    assert one.grid.data[one.grid.info.cell_of(8.0, 2.5)] == UNKNOWN
    outside, _, _ = import_plan(walls, "a.svg", PlanOptions(outside_is_free=True, **options))
    assert outside.grid.data[0, 0] == FREE
    with pytest.raises(InvalidInput, match="not within walls"):
        import_plan(walls, "a.svg", PlanOptions(start=(0.5, 0.5), **options))


def test_walls_with_a_gap_to_the_outside_leave_all_free():
    open_plan = svg_plan('<rect x="90" y="200" width="30" height="100" fill="white"/>')
    imported, report, _ = import_plan(open_plan, "a.svg", PlanOptions(scale=BY_UNITS))
    assert imported.grid.data[imported.grid.info.cell_of(0.5, 0.5)] == FREE
    assert any("gaps to the outside" in entry.text for entry in report.entries)


def test_a_plan_on_black_is_the_same():
    white = svg_plan('<rect width="1000" height="500" fill="white" style="mix-blend-mode:difference"/>')
    black, report, _ = import_plan(white, "a.svg", PlanOptions(scale=BY_UNITS))
    expected, _, _ = import_plan(svg_plan(), "a.svg", PlanOptions(scale=BY_UNITS))
    assert (black.grid.data == expected.grid.data).mean() > 0.98
    assert any(entry.part == "background" for entry in report.entries)


def test_thin_lines_may_be_left_out():
    drawn = svg_plan('<path d="M300 100V400" stroke="black" stroke-width="2"/>')
    with_line, _, _ = import_plan(drawn, "a.svg", PlanOptions(scale=BY_UNITS))
    without, report, _ = import_plan(drawn, "a.svg", PlanOptions(scale=BY_UNITS, thinnest=0.06))
    cell = with_line.grid.info.cell_of(3.0, 2.5)
    assert (with_line.grid.data[cell], without.grid.data[cell]) == (OCCUPIED, FREE)
    assert any("thinner than 0.06 m" in entry.text for entry in report.entries)
    assert without.grid.data[without.grid.info.cell_of(1.0, 2.5)] == OCCUPIED


@pytest.mark.parametrize(
    ("content", "name", "scale", "reason"),
    [
        (picture_plan(), "plan.png", None, "--scale-by"),
        (picture_plan(), "plan.docx", BY_PIXELS, "not a floor plan"),
        (picture_plan()[:100], "plan.png", BY_PIXELS, "cannot be read|truncated|broken"),
        (picture_plan(), "plan.png", ScaleBar((0, 0), (1, 0), 5000.0), "cells"),
        (svg_plan(), "plan.svg", ScaleBar((0, 0), (1, 0), 5000.0), "cells"),
        (dxf_plan(), "plan.dxf", ScaleBar((0, 0), (1, 0), 5000.0), "cells"),
        (picture_plan("PDF"), "plan.pdf", ScaleBar((0, 0), (1, 0), 5000.0), "cells"),
        (svg_plan().replace(b"#222", b"#eee"), "plan.svg", BY_UNITS, "no walls"),
        (dxf_plan(unit=0), "plan.dxf", None, "names no unit"),
        (b"0\nSECTION\n", "plan.dxf", BY_UNITS, "DXF"),
        (b"%PDF-1.4 nothing", "plan.pdf", BY_PIXELS, "PDF cannot be read"),
        (b"<svg", "plan.svg", BY_PIXELS, "not valid XML"),
        (b'<!DOCTYPE s [<!ENTITY a "b">]><svg>&a;</svg>', "plan.svg", BY_PIXELS, "not valid XML"),
        (b"<html/>", "plan.svg", BY_PIXELS, "root is 'html'"),
        (b'<svg xmlns="http://www.w3.org/2000/svg"/>', "plan.svg", BY_PIXELS, "no size"),
    ],
)  # fmt: skip
def test_what_cannot_be_a_map_is_refused(content, name, scale, reason):
    with pytest.raises((InvalidMap, InvalidInput), match=reason):
        import_plan(content, name, PlanOptions(scale=scale))


@pytest.mark.parametrize("numbers", [((0, 0), (0, 0), 1.0), ((0, 0), (1, 0), 0.0), ((0, 0), (float("nan"), 0), 1.0)])
def test_a_scale_needs_two_points_and_a_distance(numbers):
    with pytest.raises(InvalidInput, match="two different points"):
        ScaleBar(*numbers)


def test_a_file_that_is_too_large_is_refused(monkeypatch):
    monkeypatch.setattr(plan_import, "MAX_FILE", 100)
    with pytest.raises(InvalidMap, match=r"plan.svg has \d+ bytes; at most 100 are allowed"):
        import_plan(svg_plan(), "plan.svg", PlanOptions(scale=BY_UNITS))
