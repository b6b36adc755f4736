"""Pictures on the image of a map: lanes, a trajectory, and zones, with a cross where these are wrong."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from ppaas.decoding import converted
from ppaas.errors import InvalidInput, ZoneFault
from ppaas.maps.grid import FREE, OCCUPIED_THRESHOLD, UNKNOWN, GridInfo, GridMap
from ppaas.zones.decoding import decoded
from ppaas.zones.faults import Notes
from ppaas.zones.shapes import Geometry, Ring, lines_of, rings_of
from ppaas.zones.shapes import Point as PointGeometry
from robots.pictures.path import GOAL, PATH, START, Colour, Point, check_picture

if TYPE_CHECKING:
    from ppaas.fleet.metric_roadmap import MetricRoadmap

_FREE, _WALL, _UNKNOWN = (255, 255, 255), (40, 46, 56), (214, 219, 226)


@dataclass(frozen=True, slots=True)
class GridImage:
    """Image of a map.

    Parameters
    ----------
    picture : Image
    info : GridInfo
        Geometry of the map.
    scale : float
        Edge of a pixel [m].
    """

    picture: Image.Image
    info: GridInfo
    scale: float

    @classmethod
    def of(cls, grid: GridMap, most: int, least: int = 0) -> "GridImage":
        """Return the image of a map.

        Parameters
        ----------
        grid : GridMap
            A wall in a reduced cell stays visible.
        most, least : int
            Longest side of the image [pixels]: larger and smaller maps are reduced and enlarged by whole factors.
        """
        longest = max(grid.data.shape)
        factor, larger = max(1, -(-longest // most)), max(1, least // longest)
        picture = Image.fromarray(_colours(_reduced(grid.data, factor))[::-1])
        if larger > 1:
            picture = picture.resize((picture.width * larger, picture.height * larger), Image.Resampling.NEAREST)
        return cls(picture, grid.info, grid.info.resolution * factor / larger)

    def pixels(self, points: NDArray[np.float64]) -> list[tuple[float, float]]:
        """Return the pixels of (n, 2) points in the frame of the map [m]; the map is not turned in it."""
        found = (points - (self.info.origin.x, self.info.origin.y)) / self.scale
        return [(float(x), float(self.picture.height - y)) for x, y in found]

    def write(self, path: Path) -> None:
        """Write the picture to a file; raise ``InvalidInput`` if that fails."""
        try:
            self.picture.save(path)
        except OSError as error:
            raise InvalidInput(f"cannot write the picture: {error}") from error


def _reduced(cells: NDArray[np.int8], factor: int) -> NDArray[np.int8]:
    """Return cells of which each is the maximum of ``factor``² ones, so that walls win over free and unknown cells."""
    if factor == 1:
        return cells
    height, width = (-(-side // factor) for side in cells.shape)
    padded = np.full((height * factor, width * factor), UNKNOWN, np.int8)
    padded[: cells.shape[0], : cells.shape[1]] = cells
    reduced: NDArray[np.int8] = padded.reshape(height, factor, width, factor).max(axis=(1, 3))
    return reduced


def _colours(cells: NDArray[np.int8]) -> NDArray[np.uint8]:
    colours = np.full((*cells.shape, 3), _UNKNOWN, np.uint8)
    colours[(cells >= FREE) & (cells < OCCUPIED_THRESHOLD)] = _FREE
    colours[cells >= OCCUPIED_THRESHOLD] = _WALL
    return colours


# -- picture of the lanes of a map, and of the cells that robots have along them ---------------------------------------

MOST_LANE_PIXELS, LEAST_OF_LANES = 4000, 1000
"""Longest side of a picture [pixels]."""

_CELL, _ONE_WAY = (168, 199, 245), (205, 38, 74)


def write_lanes(path: Path, grid: GridMap, cells: "MetricRoadmap") -> None:
    """Draw a map with the cells along its lanes and write it to a PNG file.

    Raises
    ------
    InvalidInput
        The file name does not end with ``.png``, or the file cannot be written.
    """
    check_picture(path)
    draw_lanes(grid, cells).write(path)


def draw_lanes(grid: GridMap, cells: "MetricRoadmap") -> GridImage:
    """Return the picture: a disc for each cell, as wide as it is, blue lines both ways, and red arrows one way."""
    image = GridImage.of(grid, MOST_LANE_PIXELS, LEAST_OF_LANES)
    brush = ImageDraw.Draw(image.picture)
    points = image.pixels(cells.centres)
    radius = cells.spacing / 2.0 / image.scale
    for x, y in points:
        brush.ellipse((x - radius, y - radius, x + radius, y + radius), outline=_CELL, width=2)
    moves = {(one, other) for one, other in cells.roadmap.moves.tolist()}
    for one, other in sorted(moves):
        both = (other, one) in moves
        brush.line((points[one], points[other]), fill=PATH if both else _ONE_WAY, width=3)
        if not both:
            brush.polygon(_head(points[one], points[other], 0.45 * radius), fill=_ONE_WAY)
    dot = max(0.15 * radius, 2.0)
    for x, y in points:
        brush.ellipse((x - dot, y - dot, x + dot, y + dot), fill=PATH)
    return image


def _head(begin: Point, end: Point, size: float) -> list[Point]:
    """Return the corners of the head of an arrow in the middle of a line."""
    angle = math.atan2(end[1] - begin[1], end[0] - begin[0])
    middle = (np.array(begin) + np.array(end)) / 2.0
    corners = ((size, angle), (size, angle + 2.5), (size, angle - 2.5))
    return [
        (float(middle[0] + length * math.cos(to)), float(middle[1] + length * math.sin(to))) for length, to in corners
    ]


# -- picture of a map and the trajectory on which it was made ----------------------------------------------------------

MOST_TRAJECTORY_PIXELS = 4000
"""Longest side of a picture [pixels]; larger maps are reduced by whole factors."""

_DOT = 4
"""Radius of the dots at the start and the end [pixels]."""


def write_trajectory(path: Path, grid: GridMap, poses: NDArray[np.float64]) -> None:
    """Draw a map with a trajectory and write it to a PNG file.

    Raises
    ------
    InvalidInput
        The file name does not end with ``.png``, or the file cannot be written.
    """
    check_picture(path)
    draw_trajectory(grid, poses).write(path)


def draw_trajectory(grid: GridMap, poses: NDArray[np.float64]) -> GridImage:
    """Return the picture: the map with north up, the trajectory, a green dot at its start and a red one at its end.

    Parameters
    ----------
    grid : GridMap
        A wall in a reduced cell stays visible.
    poses : (n, 3) array
        x, y [m], theta [rad] in the map frame.
    """
    image = GridImage.of(grid, MOST_TRAJECTORY_PIXELS)
    brush = ImageDraw.Draw(image.picture)
    points = image.pixels(poses[:, :2])
    brush.line(points, fill=PATH)
    for (x, y), colour in ((points[0], START), (points[-1], GOAL)):
        brush.ellipse((x - _DOT, y - _DOT, x + _DOT, y + _DOT), fill=colour)
    return image


MOST_OF_ZONES, LEAST_OF_ZONES = 4000, 1000
"""Longest side of a picture [pixels]."""

# -- picture of zones on a map, also of those that are not valid -------------------------------------------------------

_COLOURS: dict[str, Colour] = {
    "keep_out": (205, 38, 74), "speed_limit": (226, 142, 20), "one_way": (23, 95, 214), "lane": (23, 95, 214),
    "no_stop": (128, 60, 180), "capacity": (20, 140, 85), "station": (150, 90, 20),
    "door": (190, 80, 30), "lift": (110, 70, 190), "passage": (110, 70, 190), "dock": (40, 120, 60),
}  # fmt: skip
_OTHER, _FAULT = (105, 113, 125), (255, 0, 0)
_OPACITY = 60
_ARROW, _STATION = 8.0, 5.0
"""Size of the heads of arrows on one-way lanes, and radius of stations [pixels]."""

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
    draw_zones(grid, geojson, faults).write(path)


def draw_zones(
    grid: GridMap,
    geojson: bytes,
    faults: Sequence[ZoneFault] = (),
    *,
    most: int = MOST_OF_ZONES,
    least: int = LEAST_OF_ZONES,
) -> GridImage:
    """Return the picture; its longest side has ``most`` pixels at most, and ``least`` if the map is smaller."""
    image = GridImage.of(grid, most, least)
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
    points = [[geometry.coordinates]] if isinstance(geometry, PointGeometry) else []
    for line in lines_of(geometry):
        places = _pixels(image, line)
        brush.line(places, fill=colour, width=3)
        if rule.get("one_way") is True:
            for begin, end in pairwise(places):
                brush.polygon(_head(begin, end, _ARROW), fill=_ONE_WAY)
    for x, y in (place for point in points for place in _pixels(image, point)):
        brush.ellipse((x - _STATION, y - _STATION, x + _STATION, y + _STATION), fill=colour)
    drawn = [places for part in (*rings_of(geometry), *lines_of(geometry), *points) if (places := _pixels(image, part))]
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
