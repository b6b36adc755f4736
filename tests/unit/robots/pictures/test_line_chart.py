"""Charts show every line, where its numbers are."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ppaas.errors import InvalidInput
from robots.pictures import line_chart
from robots.pictures.line_chart import Axis, Line

LINES = [Line("rising", [(0.0, 0.0), (5.0, 50.0), (10.0, 100.0)]), Line("flat", [(0.0, 20.0), (10.0, 20.0)])]


def colours(picture: Image.Image) -> set[tuple[int, ...]]:
    return set(map(tuple, np.asarray(picture).reshape(-1, 3).tolist()))


def at(picture: Image.Image, across: float, upward: float) -> tuple[int, ...]:
    """Return the colour at a share of the width and of the height of where lines are drawn."""
    width, height = (
        line_chart.WIDTH - line_chart.LEFT - line_chart.RIGHT,
        line_chart.HEIGHT - line_chart.TOP - line_chart.BOTTOM,
    )
    pixel = picture.getpixel(
        (round(line_chart.LEFT + across * width), round(line_chart.HEIGHT - line_chart.BOTTOM - upward * height))
    )
    assert isinstance(pixel, tuple)
    return pixel


def test_lines_are_where_their_numbers_are() -> None:
    picture = line_chart.draw("a chart", LINES, Axis("m"), Axis("ms"))
    assert at(picture, 0.5, 0.5) == line_chart.COLOURS[0]
    assert at(picture, 0.8, 0.2) == line_chart.COLOURS[1]
    assert at(picture, 0.87, 0.53) == line_chart.PAPER


def test_equal_ratios_are_equally_long_on_a_logarithmic_axis() -> None:
    lines = [Line("tenfold", [(1.0, 1.0), (10.0, 10.0), (100.0, 100.0)])]
    picture = line_chart.draw("a chart", lines, Axis("cells", logarithmic=True), Axis("ns", logarithmic=True))
    assert at(picture, 0.5, 0.5) == line_chart.COLOURS[0]


@pytest.mark.parametrize("value", [0.0, 1e-9, 1.0, 12345.6])
def test_a_single_point_can_be_drawn(value: float) -> None:
    assert line_chart.COLOURS[0] in colours(line_chart.draw("", [Line("", [(1.0, value)])], Axis(""), Axis("")))


def test_more_lines_than_colours_are_all_drawn() -> None:
    lines = [Line(str(number), [(0.0, number), (1.0, number)]) for number in range(1, 9)]
    assert set(line_chart.COLOURS) <= colours(line_chart.draw("", lines, Axis(""), Axis("")))


def test_a_line_may_be_dashed_and_have_the_colour_of_another() -> None:
    lines = [Line("a", [(0.0, 1.0), (2.0, 1.0)]), Line("b", [(0.0, 2.0), (2.0, 2.0)], colour=0, dashed=True)]
    picture = line_chart.draw("", lines, Axis(""), Axis(""))
    assert line_chart.COLOURS[1] not in colours(picture)
    drawn = {at(picture, share, 0.5) == line_chart.COLOURS[0] for share in np.linspace(0.1, 0.9, 50)}
    dashes = {at(picture, share, 1.0) == line_chart.COLOURS[0] for share in np.linspace(0.1, 0.9, 50)}
    assert (drawn, dashes) == ({True}, {True, False})


def test_a_chart_is_a_png_file(tmp_path: Path) -> None:
    line_chart.write_chart(tmp_path / "chart.png", "a chart", LINES, Axis("m"), Axis("ms"))
    with Image.open(tmp_path / "chart.png") as picture:
        assert picture.size == (line_chart.WIDTH, line_chart.HEIGHT)
    for path in (tmp_path / "chart.svg", tmp_path / "none" / "chart.png"):
        with pytest.raises(InvalidInput):
            line_chart.write_chart(path, "a chart", LINES, Axis("m"), Axis("ms"))
