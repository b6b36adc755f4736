"""Picture of the lanes of a map, and of the cells that robots have along them."""

import math
from pathlib import Path

import numpy as np
from PIL import ImageDraw

from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.maps.grid import GridMap
from robots.pictures.grid_image import GridImage
from robots.pictures.path import PATH, Point, check_picture

MOST, LEAST = 4000, 1000
"""Longest side of a picture [pixels]."""

_CELL, _ONE_WAY = (168, 199, 245), (205, 38, 74)


def write_lanes(path: Path, grid: GridMap, cells: MetricRoadmap) -> None:
    """Draw a map with the cells along its lanes and write it to a PNG file.

    Raises
    ------
    InvalidInput
        The file name does not end with ``.png``, or the file cannot be written.
    """
    check_picture(path)
    draw(grid, cells).write(path)


def draw(grid: GridMap, cells: MetricRoadmap) -> GridImage:
    """Return the picture: a disc for each cell, as wide as it is, blue lines both ways, and red arrows one way."""
    image = GridImage.of(grid, MOST, LEAST)
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
