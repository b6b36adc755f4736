"""Picture of the floors of a building, side by side, with their lifts, doors, docks and lanes."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from ppaas.errors import InvalidInput
from ppaas.maps.grid import GridMap
from robots.pictures.map_pictures import draw_zones
from robots.pictures.path import FAINT, GOAL, INK, PAPER, START, check_picture

_GAP, _HEAD, _DOT = 24, 40, 5
_ROUTE = (222, 31, 113)
"""Colour of paths, which is not the one of lanes."""

_MOST, _LEAST = 900, 400
"""Longest side of a floor [pixels], and that to which a small one is enlarged."""


@dataclass(frozen=True, slots=True)
class FloorPicture:
    """Floor to draw: its name, its map, the zones on it as GeoJSON, and paths as rows that begin with x, y [m]."""

    name: str
    grid: GridMap
    geojson: bytes
    paths: Sequence[Sequence[Sequence[float]]] = ()

    def drawn(self) -> Image.Image:
        """Return the floor with its zones, and above them the paths, with dots at both ends of each."""
        image = draw_zones(self.grid, self.geojson, most=_MOST, least=_LEAST)
        brush = ImageDraw.Draw(image.picture)
        for path in self.paths:
            points = image.pixels(np.array([row[:2] for row in path], float))
            brush.line(points, fill=_ROUTE, width=5)
            for (x, y), colour in ((points[0], START), (points[-1], GOAL)):
                brush.ellipse((x - _DOT, y - _DOT, x + _DOT, y + _DOT), fill=colour)
        return image.picture


def write_floors(path: Path, floors: Sequence[FloorPicture]) -> None:
    """Draw floors side by side, and write the picture to a PNG file.

    Raises
    ------
    InvalidInput
        The file name does not end with ``.png``, or the file cannot be written.
    """
    check_picture(path)
    pictures = [each.drawn() for each in floors]
    width = sum(picture.width + _GAP for picture in pictures) + _GAP
    height = max(picture.height for picture in pictures) + _HEAD + _GAP
    sheet = Image.new("RGB", (width, height), PAPER)
    brush = ImageDraw.Draw(sheet)
    left = _GAP
    for floor, picture in zip(floors, pictures, strict=True):
        brush.text((left, _HEAD // 4), floor.name, INK, font_size=18)
        sheet.paste(picture, (left, _HEAD))
        brush.rectangle((left - 1, _HEAD - 1, left + picture.width, _HEAD + picture.height), outline=FAINT)
        left += picture.width + _GAP
    try:
        sheet.save(path)
    except OSError as error:
        raise InvalidInput(f"cannot write the picture: {error}") from error
