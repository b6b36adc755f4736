"""Line charts of what was measured, drawn as the pictures of paths are."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from ppaas.errors import InvalidInput
from robots.pictures.path import FAINT, INK, PAPER, check_picture

COLOURS = ((23, 95, 214), (205, 38, 74), (20, 140, 85), (214, 137, 16), (122, 66, 190), (90, 98, 110))
GRID = (228, 231, 235)
WIDTH, HEIGHT = 900, 560
LEFT, RIGHT, TOP, BOTTOM = 84, 24, 116, 64
OVERSAMPLING = 2
DASH = 10.0
"""From the beginning of a dash to the next [pixels]."""

Colour = tuple[int, int, int]
Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Line:
    """A named line through points (x, y).

    Parameters
    ----------
    name : str
    points : sequence of (float, float)
    colour : int, optional
        Number of the colour; lines have different ones where none is told.
    dashed : bool
        Whether it is drawn in dashes.
    """

    name: str
    points: Sequence[Point]
    colour: int | None = None
    dashed: bool = False


@dataclass(frozen=True, slots=True)
class Axis:
    """What is told along an axis.

    Parameters
    ----------
    label : str
        With the unit.
    logarithmic : bool
        Whether equal ratios are equally long; all values are then above 0.
    ticks : sequence of float
        Where lines are drawn across; none of them means at round values.
    """

    label: str
    logarithmic: bool = False
    ticks: Sequence[float] = ()


@dataclass(frozen=True, slots=True)
class _Scale:
    """From values to a share, 0 to 1, of an axis."""

    least: float
    most: float
    logarithmic: bool

    @classmethod
    def of(cls, values: Sequence[float], logarithmic: bool) -> "_Scale":
        least, most = min(values), max(values)
        if logarithmic:
            return cls(least / 1.15, most * 1.15, True)
        step = _step(max(most, 1e-12))
        return cls(0.0, math.ceil(most / step - 1e-9) * step or 1.0, False)

    def share(self, value: float) -> float:
        if self.logarithmic:
            return math.log(value / self.least) / math.log(self.most / self.least)
        return (value - self.least) / (self.most - self.least)

    def ticks(self) -> list[float]:
        """Return where lines are drawn: about five, or at 1, 2 and 5 of each decade."""
        if not self.logarithmic:
            step = _step(self.most)
            return [number * step for number in range(round(self.most / step) + 1)]
        decades = range(math.floor(math.log10(self.least)), math.ceil(math.log10(self.most)) + 1)
        digits = (1, 2, 3, 5, 7) if self.most < 10.0 * self.least else (1, 2, 5)
        ticks = [digit * 10.0**decade for decade in decades for digit in digits]
        return [tick for tick in ticks if self.least <= tick <= self.most]


def write_chart(path: Path, title: str, lines: Sequence[Line], x: Axis, y: Axis) -> None:
    """Draw a chart and write it to a PNG file.

    Raises
    ------
    InvalidInput
        The file is not called .png, or cannot be written.
    """
    check_picture(path)
    try:
        draw(title, lines, x, y).save(path)
    except OSError as error:
        raise InvalidInput(f"cannot write the chart: {error}") from error


def draw(title: str, lines: Sequence[Line], x: Axis, y: Axis) -> Image.Image:
    """Return the chart of some lines, each with one point or more."""
    sheet = Image.new("RGB", (WIDTH * OVERSAMPLING, HEIGHT * OVERSAMPLING), PAPER)
    pen = ImageDraw.Draw(sheet)
    across = _Scale.of([point[0] for line in lines for point in line.points], x.logarithmic)
    upward = _Scale.of([point[1] for line in lines for point in line.points], y.logarithmic)
    _text(pen, (LEFT, 16), title, 19)
    _draw_axes(pen, across, upward, x, y)
    place: Point = LEFT, 52
    for number, line in enumerate(lines):
        colour = COLOURS[(number if line.colour is None else line.colour) % len(COLOURS)]
        place = _draw_legend(pen, place, line, colour)
        _draw_line(pen, [_place(across, upward, point) for point in line.points], colour, dashed=line.dashed)
    return sheet.reduce(OVERSAMPLING)


def _draw_axes(pen: ImageDraw.ImageDraw, across: _Scale, upward: _Scale, x: Axis, y: Axis) -> None:
    bottom, right = HEIGHT - BOTTOM, WIDTH - RIGHT
    for tick in x.ticks or across.ticks():
        place = _place(across, upward, (tick, upward.least))[0]
        _stroke(pen, [(place, TOP), (place, bottom)], GRID, 1)
        _text(pen, (place, bottom + 8), f"{tick:,g}", 13, "ma", faint=True)
    for tick in y.ticks or upward.ticks():
        place = _place(across, upward, (across.least, tick))[1]
        _stroke(pen, [(LEFT, place), (right, place)], GRID, 1)
        _text(pen, (LEFT - 10, place), f"{tick:,g}", 13, "rm", faint=True)
    _stroke(pen, [(LEFT, TOP), (LEFT, bottom), (right, bottom)], FAINT, 1)
    _text(pen, (right, HEIGHT - 30), x.label, 14, "ra")
    _text(pen, (14, TOP - 26), y.label, 14)


def _draw_line(pen: ImageDraw.ImageDraw, places: Sequence[Point], colour: Colour, *, dashed: bool) -> None:
    for part in _dashes(places) if dashed else [places]:
        _stroke(pen, part, colour, 2)
    for x, y in places:
        box = tuple(OVERSAMPLING * edge for edge in (x - 3.5, y - 3.5, x + 3.5, y + 3.5))
        pen.ellipse(box, colour)


def _dashes(places: Sequence[Point]) -> list[Sequence[Point]]:
    """Return the dashes of a line, each straight: they begin anew at each of its points."""
    dashes: list[Sequence[Point]] = []
    for (x, y), (to_x, to_y) in pairwise(places):
        count = max(1, round(math.dist((x, y), (to_x, to_y)) / DASH))
        across, down = (to_x - x) / count, (to_y - y) / count
        dashes += [
            [(x + i * across, y + i * down), (x + (i + 0.6) * across, y + (i + 0.6) * down)] for i in range(count)
        ]
    return dashes


def _draw_legend(pen: ImageDraw.ImageDraw, place: Point, line: Line, colour: Colour) -> Point:
    """Draw what a line is called, on a new line where it does not fit; return where the next one goes."""
    width = 26 + pen.textlength(line.name, _font(13)) / OVERSAMPLING
    left, top = place if place[0] + width <= WIDTH - RIGHT else (LEFT, place[1] + 20)
    for part in _dashes([(left, top), (left + 20, top)]) if line.dashed else [[(left, top), (left + 20, top)]]:
        _stroke(pen, part, colour, 3)
    _text(pen, (left + 26, top), line.name, 13, "lm")
    return left + width + 22, top


def _place(across: _Scale, upward: _Scale, point: Point) -> Point:
    width, height = WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM
    return LEFT + across.share(point[0]) * width, HEIGHT - BOTTOM - upward.share(point[1]) * height


def _stroke(pen: ImageDraw.ImageDraw, places: Sequence[Point], colour: Colour, width: int) -> None:
    pen.line([(OVERSAMPLING * x, OVERSAMPLING * y) for x, y in places], colour, width * OVERSAMPLING, joint="curve")


def _text(
    pen: ImageDraw.ImageDraw, place: Point, text: str, font: int, anchor: str = "la", *, faint: bool = False
) -> None:
    at = place[0] * OVERSAMPLING, place[1] * OVERSAMPLING
    pen.text(at, text, FAINT if faint else INK, _font(font), anchor=anchor)


def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(size * OVERSAMPLING)


def _step(most: float) -> float:
    """Return 1, 2, 5 or 10 of a decade, so that about five steps make ``most``."""
    decade = 10.0 ** math.floor(math.log10(most / 5.0))
    return decade * next(digit for digit in (1, 2, 5, 10) if digit * decade * 5.0 >= most * 0.999)
