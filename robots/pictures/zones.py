"""Picture of zones on a map, also of those that are not valid: with a cross where they are wrong."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from PIL import Image, ImageDraw

from ppaas.decoding import converted
from ppaas.errors import ZoneFault
from ppaas.maps.grid import GridMap
from ppaas.zones.decoding import decoded
from ppaas.zones.faults import Notes
from ppaas.zones.shapes import Geometry, Ring, lines_of, rings_of
from robots.pictures.grid_image import GridImage
from robots.pictures.path import Colour, Point, check_picture

MOST, LEAST = 4000, 1000
"""Longest side of a picture [pixels]."""

_COLOURS: dict[str, Colour] = {
    "keep_out": (205, 38, 74), "speed_limit": (226, 142, 20), "one_way": (23, 95, 214), "lane": (23, 95, 214),
    "no_stop": (128, 60, 180), "capacity": (20, 140, 85),
}  # fmt: skip
_OTHER, _FAULT = (105, 113, 125), (255, 0, 0)
_OPACITY = 60
_CROSS = 14
"""Half of the size of a cross [pixels]."""

_LONGEST = 80
"""Characters of a fault that are shown."""


def write_zones(path: Path, grid: GridMap, geojson: bytes, faults: Sequence[ZoneFault] = ()) -> None:
    """Draw zones on a map and write it to a PNG file.

    Parameters
    ----------
    path : Path
    grid : GridMap
    geojson : bytes
        Feature collection; features without a geometry of zones are not drawn.
    faults : sequence of ZoneFault
        Faults of zones, each marked by a red cross at its place.

    Raises
    ------
    InvalidInput
        The file name does not end with ``.png``, or the file cannot be written.
    """
    check_picture(path)
    draw(grid, geojson, faults).write(path)


def draw(grid: GridMap, geojson: bytes, faults: Sequence[ZoneFault] = ()) -> GridImage:
    """Return the picture."""
    image = GridImage.of(grid, MOST, LEAST)
    for feature in decoded(geojson, Notes())["features"]:
        _draw_feature(image, feature)
    brush = ImageDraw.Draw(image.picture)
    for fault in faults:
        if fault.place is not None:
            _cross(brush, image.picture.width, image.pixels(np.array([fault.place]))[0], f"{fault.zone}: {fault.text}")
    return image


def _draw_feature(image: GridImage, feature: Any) -> None:
    try:
        geometry = converted(feature["geometry"], Geometry)
    except (msgspec.ValidationError, KeyError, TypeError):
        return
    properties = feature.get("properties")
    rule = properties if isinstance(properties, dict) else {}
    colour = _COLOURS.get(str(rule.get("kind")), _OTHER)
    _fill(image, [_pixels(image, ring) for ring in rings_of(geometry)], colour)
    brush = ImageDraw.Draw(image.picture)
    for line in lines_of(geometry):
        brush.line(_pixels(image, line), fill=colour, width=3)
    drawn = [places for part in (*rings_of(geometry), *lines_of(geometry)) if (places := _pixels(image, part))]
    if drawn:
        brush.text(drawn[0][0], str(rule.get("name", "")), fill=colour)


def _fill(image: GridImage, rings: list[list[Point]], colour: Colour) -> None:
    """Fill what is inside of an odd number of rings, so that the quarters of a crossed outline show."""
    inside = np.zeros(image.picture.size[::-1], np.bool_)
    for ring in (ring for ring in rings if len(ring) > 1):
        mask = Image.new("1", image.picture.size)
        ImageDraw.Draw(mask).polygon(ring, fill=1)
        inside ^= np.asarray(mask)
    tint = Image.fromarray(inside.astype(np.uint8) * _OPACITY)
    image.picture.paste(Image.new("RGB", image.picture.size, colour), mask=tint)
    brush = ImageDraw.Draw(image.picture)
    for ring in rings:
        brush.line([*ring, *ring[:1]], fill=colour, width=2)


def _pixels(image: GridImage, places: Ring) -> list[Point]:
    known = [place[:2] for place in places if len(place) > 1]
    return image.pixels(np.array(known, float)) if known else []


def _cross(brush: ImageDraw.ImageDraw, width: int, at: Point, text: str) -> None:
    x, y = at
    for turn in (1, -1):
        brush.line((x - _CROSS, y - turn * _CROSS, x + _CROSS, y + turn * _CROSS), fill=_FAULT, width=4)
    shown = text[:_LONGEST]
    right = width - brush.textlength(shown) - 4
    brush.text((max(0.0, min(x + _CROSS + 4, right)), y + _CROSS + 4), shown, fill=_FAULT)
