"""A picture of a recording that was played: the map, where the robot was, and where localization took it to be."""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from benchmarks.localization.replay import Replay
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, GridMap
from robots.pictures.path import check_picture

WALL, FLOOR, UNKNOWN = (52, 60, 72), (255, 255, 255), (214, 219, 226)
TRUE, TOLD, APART = (20, 140, 85), (23, 95, 214), (205, 38, 74)
FAR = 0.25
"""From where on what was told and what is true are joined by a line [m]."""
EDGE = 1000
"""Least pixels of the longer edge."""


def write_picture(path: Path, grid: GridMap, replay: Replay) -> None:
    """Draw into a PNG file: green where the robot was, blue where it was taken to be, red what lies between.

    Raises
    ------
    InvalidInput
        The file cannot be written.
    """
    check_picture(path)
    picture = draw(grid, replay)
    try:
        picture.save(path)
    except OSError as error:
        raise InvalidInput(f"cannot write the picture: {error}") from error


def draw(grid: GridMap, replay: Replay) -> Image.Image:
    """Return the picture."""
    colours = np.full((*grid.data.shape, 3), UNKNOWN, np.uint8)
    colours[grid.data == FREE] = FLOOR
    colours[grid.data >= OCCUPIED] = WALL
    scale = max(1, -(-EDGE // max(grid.data.shape)))
    picture = Image.fromarray(colours[::-1]).resize(
        (grid.info.width * scale, grid.info.height * scale), Image.Resampling.NEAREST
    )
    pen = ImageDraw.Draw(picture)

    def pixel(pose: Pose2D) -> tuple[float, float]:
        local = grid.info.origin.inverse() @ pose
        x, y = local.x / grid.info.resolution, grid.info.height - local.y / grid.info.resolution
        return scale * x, scale * y

    pairs = [(look.true, told) for look, told in zip(replay.looks, replay.told, strict=True)]
    for true, told in pairs:
        if true is not None and true.distance_to(told) >= FAR:
            pen.line([pixel(true), pixel(told)], APART, 1)
    pen.line([pixel(told) for _, told in pairs], TOLD, 3)
    pen.line([pixel(true) for true, _ in pairs if true is not None], TRUE, 1)
    return picture
