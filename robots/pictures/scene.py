"""Picture of a map as a scene: its zones, its robots, and lines with coordinates to point at places."""

from collections.abc import Mapping

import numpy as np
from PIL import ImageDraw

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from robots.pictures.map_pictures import GridImage, draw_zones
from robots.pictures.path import FAINT, GOAL, INK, PAPER

SPACING = 80
"""Least distance of two lines [pixels]."""

_STEPS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0)
_RADIUS = 6
_HEADING = 14


def draw_scene(grid: GridMap, zones: bytes | None, robots: Mapping[str, Pose2D], size: int) -> GridImage:
    """Return the picture.

    Parameters
    ----------
    grid : GridMap
    zones : bytes, optional
        Zones of the map as GeoJSON.
    robots : mapping of str to Pose2D
        Poses of robots by name; those off the map are left out.
    size : int
        Longest side [pixels]; smaller maps are enlarged by whole factors.
    """
    image = GridImage.of(grid, size, size) if zones is None else draw_zones(grid, zones, most=size, least=size)
    brush = ImageDraw.Draw(image.picture)
    _draw_lines(brush, image)
    for name, pose in robots.items():
        _draw_robot(brush, image, name, pose)
    return image


def _draw_lines(brush: ImageDraw.ImageDraw, image: GridImage) -> None:
    step = next((step for step in _STEPS if step / image.scale >= SPACING), _STEPS[-1])
    width, height = image.picture.size
    origin = image.info.origin
    for number in _multiples(origin.x, width * image.scale, step):
        x = (number - origin.x) / image.scale
        brush.line((x, 0, x, height), fill=FAINT)
        brush.text((x + 3, height - 14), f"{number:g}", fill=INK, stroke_width=2, stroke_fill=PAPER)
    for number in _multiples(origin.y, height * image.scale, step):
        y = height - (number - origin.y) / image.scale
        brush.line((0, y, width, y), fill=FAINT)
        brush.text((3, y - 13), f"{number:g}", fill=INK, stroke_width=2, stroke_fill=PAPER)


def _multiples(begin: float, length: float, step: float) -> list[float]:
    first, last = int(np.ceil(begin / step)), int(np.floor((begin + length) / step))
    return [round(number * step, 6) for number in range(first, last + 1)]


def _draw_robot(brush: ImageDraw.ImageDraw, image: GridImage, name: str, pose: Pose2D) -> None:
    (x, y), (tip_x, tip_y) = image.pixels(
        np.array([pose[:2], (pose.x + np.cos(pose.theta) * image.scale, pose.y + np.sin(pose.theta) * image.scale)])
    )
    width, height = image.picture.size
    if not (0.0 <= x <= width and 0.0 <= y <= height):
        return
    brush.line((x, y, x + _HEADING * (tip_x - x), y + _HEADING * (tip_y - y)), fill=GOAL, width=3)
    brush.ellipse((x - _RADIUS, y - _RADIUS, x + _RADIUS, y + _RADIUS), fill=GOAL, outline=PAPER)
    brush.text((x + _RADIUS + 4, y - _RADIUS), name, fill=INK, stroke_width=2, stroke_fill=PAPER)
