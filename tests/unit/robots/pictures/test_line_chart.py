"""Charts show every line, at its numbers and in its style."""

import sys
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from PIL import Image

from ppaas.errors import InvalidInput
from robots.pictures import line_chart
from robots.pictures.figure_file import check_figure
from robots.pictures.line_chart import Axis, Line

LINES = [Line("rising", [(0.0, 0.0), (5.0, 50.0), (10.0, 100.0)]), Line("flat", [(0.0, 20.0), (10.0, 20.0)])]


def drawn(lines: list[Line], x: Axis, y: Axis) -> Axes:
    """Return the axes of a chart after it was rendered once."""
    figure = line_chart.draw("a chart", lines, x, y)
    figure.draw_without_rendering()
    return figure.axes[0]


def test_lines_have_their_points_names_and_labels() -> None:
    axes = drawn(LINES, Axis("m"), Axis("ms"))
    assert (axes.get_title(), axes.get_xlabel(), axes.get_ylabel()) == ("a chart", "m", "ms")
    assert {line.get_label(): line.get_xydata().tolist() for line in axes.lines} == {
        line.name: [list(point) for point in line.points] for line in LINES
    }
    assert len({line.get_color() for line in axes.lines}) == 2
    assert [text.get_text() for text in axes.figure.legends[0].get_texts()] == ["rising", "flat"]


def test_a_linear_axis_starts_at_zero() -> None:
    axes = drawn([Line("", [(3.0, 20.0), (4.0, 30.0)])], Axis(""), Axis(""))
    assert (axes.get_xlim()[0], axes.get_ylim()[0]) == (0.0, 0.0)


def test_a_logarithmic_axis_is_labelled_by_digits_at_1_2_and_5() -> None:
    lines = [Line("tenfold", [(1.0, 1.0), (1000.0, 1000.0)])]
    axes = drawn(lines, Axis("cells", logarithmic=True), Axis("ns"))
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "linear")
    assert {"1", "2", "5", "10", "1,000"} <= {label.get_text() for label in axes.get_xticklabels()}


def test_given_ticks_are_labelled() -> None:
    axes = drawn([Line("", [(256.0, 1.0), (512.0, 1.0)])], Axis("", True, (256, 512)), Axis(""))
    assert [label.get_text() for label in axes.get_xticklabels()] == ["256", "512"]


@pytest.mark.parametrize("value", [0.0, 1e-9, 1.0, 12345.6])
def test_a_single_point_can_be_drawn(value: float) -> None:
    [line] = drawn([Line("", [(1.0, value)])], Axis(""), Axis("")).lines
    assert line.get_marker() == "o"


def test_more_lines_than_colours_are_all_drawn() -> None:
    lines = [Line(str(number), [(0.0, number), (1.0, number)]) for number in range(1, 13)]
    assert len(drawn(lines, Axis(""), Axis("")).lines) == 12


def test_a_line_may_be_dashed_and_have_the_colour_of_another() -> None:
    lines = [Line("a", [(0.0, 1.0), (2.0, 1.0)]), Line("b", [(0.0, 2.0), (2.0, 2.0)], colour=0, dashed=True)]
    solid, dashed = drawn(lines, Axis(""), Axis("")).lines
    assert solid.get_color() == dashed.get_color()
    assert (solid.get_linestyle(), dashed.get_linestyle()) == ("-", "--")


def test_points_of_a_long_line_are_not_marked() -> None:
    points = [(float(x), 1.0) for x in np.arange(line_chart.MOST_MARKED + 1)]
    assert drawn([Line("", points)], Axis(""), Axis("")).lines[0].get_marker() == ""


def test_a_chart_is_a_png_file(tmp_path: Path) -> None:
    line_chart.write_chart(tmp_path / "chart.png", "a chart", LINES, Axis("m"), Axis("ms"))
    with Image.open(tmp_path / "chart.png") as picture:
        assert picture.size == tuple(round(100 * inches) for inches in line_chart.SIZE)
    for path in (tmp_path / "chart.svg", tmp_path / "none" / "chart.png"):
        with pytest.raises(InvalidInput):
            line_chart.write_chart(path, "a chart", LINES, Axis("m"), Axis("ms"))


def test_equal_charts_are_equal_files(tmp_path: Path) -> None:
    for name in ("one.png", "two.png"):
        line_chart.write_chart(tmp_path / name, "a chart", LINES, Axis("m"), Axis("ms"))
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "two.png").read_bytes()


def test_only_png_files_are_written() -> None:
    check_figure(Path("chart.PNG"))
    with pytest.raises(InvalidInput, match="PNG"):
        check_figure(Path("chart.pdf"))


def test_a_missing_matplotlib_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.delitem(sys.modules, "matplotlib.figure", raising=False)
    with pytest.raises(ModuleNotFoundError) as missing:
        check_figure(Path("chart.png"))
    assert (missing.value.name or "").partition(".")[0] == "matplotlib"
