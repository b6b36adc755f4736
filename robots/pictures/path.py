"""Picture of a path: the part of the inflated map that shows it, the path, its start and its goal."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw, ImageFont

from ppaas.costmap.costmap import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION, Costmap
from ppaas.errors import InvalidInput
from ppaas.geometry import Poses, yaw_of

WIDEST, HIGHEST = 1400, 1000
"""Largest size of the map in the picture [pixels]."""

OVERSAMPLING = 2
"""Factor by which everything is drawn larger and then reduced, for smooth lines."""

MARGIN = 8
"""Margin around the known cells [cells]."""

FREE, UNKNOWN, OBSTACLE = (253, 253, 251), (221, 225, 230), (40, 46, 56)
NEAR, FAR, INSCRIBED = (247, 178, 103), (253, 240, 222), (238, 125, 88)


def palette() -> NDArray[np.uint8]:
    """Return the (256, 3) RGB colours of the costs."""
    share = np.linspace(0.0, 1.0, LETHAL_OBSTACLE)[:, np.newaxis]
    colours = np.zeros((256, 3))
    colours[:LETHAL_OBSTACLE] = (1.0 - share) * FAR + share * NEAR
    for cost, colour in (
        (0, FREE), (INSCRIBED_INFLATED_OBSTACLE, INSCRIBED), (LETHAL_OBSTACLE, OBSTACLE), (NO_INFORMATION, UNKNOWN),
    ):  # fmt: skip
        colours[cost] = colour
    return colours.astype(np.uint8)


@dataclass(frozen=True, slots=True)
class View:
    """Magnified window of a costmap.

    Parameters
    ----------
    costmap : Costmap
        The whole costmap.
    top, bottom, left, right : int
        Bounds of the window [cells]; ``top`` and ``right`` are exclusive.
    scale : float
        Pixels per cell.
    """

    costmap: Costmap
    top: int
    bottom: int
    left: int
    right: int
    scale: float

    @classmethod
    def of(cls, costmap: Costmap, points: NDArray[np.float64]) -> "View":
        """Return the view that contains all known cells and some points."""
        height, width = costmap.data.shape
        known = costmap.data != NO_INFORMATION
        rows, columns = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
        cells = costmap.info.to_cells(points)
        rows, columns = np.concatenate((rows, cells[:, 0])), np.concatenate((columns, cells[:, 1]))
        bottom, top = max(0, rows.min() - MARGIN), min(height, rows.max() + 1 + MARGIN)
        left, right = max(0, columns.min() - MARGIN), min(width, columns.max() + 1 + MARGIN)
        fits = min(WIDEST / (right - left), HIGHEST / (top - bottom))
        # A whole number of pixels per cell if possible, so all cells have the same size.
        scale = OVERSAMPLING * (float(int(fits)) if fits >= 1.0 else fits)
        return cls(costmap, int(top), int(bottom), int(left), int(right), scale)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height [pixels]."""
        width, height = (self.right - self.left) * self.scale, (self.top - self.bottom) * self.scale
        return max(1, round(width)), max(1, round(height))

    def picture(self) -> Image.Image:
        """Return the image of the costmap."""
        cells = self.costmap.data[self.bottom : self.top, self.left : self.right][::-1]
        coloured = Image.fromarray(palette()[cells])
        how = Image.Resampling.NEAREST if self.scale >= 1.0 else Image.Resampling.BOX
        return coloured.resize(self.size, how)

    def pixels(self, points: ArrayLike) -> list[tuple[float, float]]:
        """Return the pixels of (n, 2) points [m], counted from the upper left corner."""
        info = self.costmap.info
        local = np.asarray(points, dtype=np.float64) - (info.origin.x, info.origin.y)
        c, s = np.cos(info.origin.theta), np.sin(info.origin.theta)
        columns = (c * local[:, 0] + s * local[:, 1]) / info.resolution - self.left
        rows = self.top - (c * local[:, 1] - s * local[:, 0]) / info.resolution
        return list(zip((columns * self.scale).tolist(), (rows * self.scale).tolist(), strict=True))

    @property
    def metre(self) -> float:
        """Pixels per metre."""
        return self.scale / self.costmap.info.resolution


INK, FAINT, PAPER = (28, 33, 41), (105, 113, 125), (255, 255, 255)
PATH, START, GOAL = (23, 95, 214), (20, 140, 85), (205, 38, 74)

_LEGEND = (
    ("path", PATH), ("start", START), ("goal", GOAL), ("obstacle", OBSTACLE),
    ("collision", INSCRIBED), ("near", NEAR), ("free", FREE), ("unknown", UNKNOWN),
)  # fmt: skip
_PAD, _HEAD, _FOOT, _NARROWEST = 24, 74, 58, 860

Box = tuple[float, float, float, float]
Colour = tuple[int, int, int]
Point = tuple[float, float]


def check_picture(path: Path) -> None:
    """Raise ``InvalidInput`` unless a file name ends in ``.png``."""
    if path.suffix.lower() != ".png":
        raise InvalidInput(f"pictures are PNG files; use {path.stem or 'path'}.png, not {str(path)!r}")


def write_picture(
    path: Path, costmap: Costmap, poses: Poses, *, radius: float, title: str, facts: Sequence[str]
) -> None:
    """Draw a path and write it to a PNG file.

    Parameters
    ----------
    path : Path
        PNG file to write.
    costmap, poses, radius, title, facts
        As in ``draw``.

    Raises
    ------
    InvalidInput
        The file cannot be written.
    """
    check_picture(path)
    picture = draw(costmap, poses, radius=radius, title=title, facts=facts)
    try:
        picture.save(path)
    except OSError as error:
        raise InvalidInput(f"cannot write the picture: {error}") from error


def draw(costmap: Costmap, poses: Poses, *, radius: float, title: str, facts: Sequence[str]) -> Image.Image:
    """Return the picture of a path.

    Parameters
    ----------
    costmap : Costmap
        Inflated for the robot.
    poses : (n, 7) array
        One pose or more, in the frame of the costmap.
    radius : float
        Radius of the robot, drawn at start and goal [m].
    title : str
        Title.
    facts : sequence of str
        Facts in the line below the title.
    """
    view = View.of(costmap, poses[:, :2])
    pad, head, foot, narrowest = (n * OVERSAMPLING for n in (_PAD, _HEAD, _FOOT, _NARROWEST))
    width, height = view.size
    sheet = Image.new("RGB", (max(width, narrowest) + 2 * pad, head + height + foot), PAPER)
    left = (sheet.width - width) // 2
    sheet.paste(view.picture(), (left, head))
    pen = ImageDraw.Draw(sheet)
    _write_head(pen, title, "   ·   ".join(facts))
    _draw_foot(pen, view, (left, head, left + width - 1, head + height - 1))
    # Drawn on the sheet, not on the map, so symbols at the map's edge are not cut off.
    points = [(x + left, y + head) for x, y in view.pixels(poses[:, :2])]
    _draw_path(pen, points)
    turn = costmap.info.origin.theta
    for at, colour in ((0, START), (-1, GOAL)):
        _draw_robot(pen, points[at], yaw_of(*poses[at, 3:].tolist()) - turn, radius * view.metre, colour)
    return sheet.reduce(OVERSAMPLING)


# -- the parts ---------------------------------------------------------------------------------------------------------


def _write_head(pen: ImageDraw.ImageDraw, title: str, line: str) -> None:
    pen.text((_PAD * OVERSAMPLING, 14 * OVERSAMPLING), title, INK, _font(22))
    pen.text((_PAD * OVERSAMPLING, 44 * OVERSAMPLING), line, FAINT, _font(15))


def _draw_path(pen: ImageDraw.ImageDraw, points: Sequence[Point]) -> None:
    for colour, width in ((PAPER, 6.0), (PATH, 3.0)):
        pen.line(points, colour, round(width * OVERSAMPLING), joint="curve")


def _draw_robot(pen: ImageDraw.ImageDraw, place: Point, heading: float, footprint: float, colour: Colour) -> None:
    """Draw the footprint to scale, a disc of constant size, and the heading."""
    x, y = place
    disc = 7.0 * OVERSAMPLING
    reach = max(footprint, disc) + 9.0 * OVERSAMPLING
    tip = x + reach * math.cos(heading), y - reach * math.sin(heading)
    for width, shade in ((6.0, PAPER), (3.0, colour)):
        pen.line([(x, y), tip], shade, round(width * OVERSAMPLING))
    if footprint > disc:
        pen.ellipse(_around(x, y, footprint), outline=colour, width=round(1.5 * OVERSAMPLING))
    pen.ellipse(_around(x, y, disc + 2.0 * OVERSAMPLING), PAPER)
    pen.ellipse(_around(x, y, disc), colour)


def _draw_foot(pen: ImageDraw.ImageDraw, view: View, box: Box) -> None:
    left, _, right, bottom = box
    pen.rectangle(box, outline=FAINT, width=OVERSAMPLING)
    left, right = min(left, _PAD * OVERSAMPLING), max(right, (_PAD + _NARROWEST) * OVERSAMPLING)
    y = bottom + 30 * OVERSAMPLING
    length = _round_length((right - left) / 6.0 / view.metre)
    end = left + length * view.metre
    pen.line([(left, y), (end, y)], INK, 2 * OVERSAMPLING)
    for x in (left, end):
        pen.line([(x, y - 5 * OVERSAMPLING), (x, y + 5 * OVERSAMPLING)], INK, 2 * OVERSAMPLING)
    pen.text((end + 8 * OVERSAMPLING, y), f"{length:g} m", INK, _font(14), anchor="lm")
    x = right
    for name, colour in reversed(_LEGEND):
        x -= pen.textlength(name, _font(14))
        pen.text((x, y), name, INK, _font(14), anchor="lm")
        x -= 20 * OVERSAMPLING
        pen.rounded_rectangle(_around(x + 6 * OVERSAMPLING, y, 6 * OVERSAMPLING), 3 * OVERSAMPLING, colour, FAINT)
        x -= 16 * OVERSAMPLING


# -- measures ----------------------------------------------------------------------------------------------------------


def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(size * OVERSAMPLING)


def _around(x: float, y: float, radius: float) -> Box:
    return x - radius, y - radius, x + radius, y + radius


def _round_length(most: float) -> float:
    """Return the largest of 1, 2, 5 × 10ⁿ that is not above ``most`` [m]."""
    decade = 10.0 ** math.floor(math.log10(most))
    return decade * float(np.array([1.0, 2.0, 5.0])[np.array([1.0, 2.0, 5.0]) <= most / decade].max())
