"""Picture of a map and the trajectory on which it was made."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from ppaas.errors import InvalidInput
from ppaas.maps.grid import FREE, OCCUPIED_THRESHOLD, UNKNOWN, GridMap
from robots.pictures.path import GOAL, PATH, START, check_picture

MOST = 4000
"""Longest side of a picture [pixels]; larger maps are reduced by whole factors."""

_FREE, _WALL, _UNKNOWN = (255, 255, 255), (40, 46, 56), (214, 219, 226)
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
    picture = draw(grid, poses)
    try:
        picture.save(path)
    except OSError as error:
        raise InvalidInput(f"cannot write the picture: {error}") from error


def draw(grid: GridMap, poses: NDArray[np.float64]) -> Image.Image:
    """Return the picture: the map with north up, the trajectory, a green dot at its start and a red one at its end.

    Parameters
    ----------
    grid : GridMap
        A wall in a reduced cell stays visible.
    poses : (n, 3) array
        x, y [m], theta [rad] in the map frame.
    """
    factor = max(1, -(-max(grid.data.shape) // MOST))
    picture = Image.fromarray(_colours(_reduced(grid.data, factor))[::-1])
    info = grid.info
    scale = info.resolution * factor
    pixels = (poses[:, :2] - (info.origin.x, info.origin.y)) / scale
    pixels[:, 1] = picture.height - pixels[:, 1]
    brush = ImageDraw.Draw(picture)
    points = [(float(x), float(y)) for x, y in pixels]
    brush.line(points, fill=PATH)
    for (x, y), colour in ((points[0], START), (points[-1], GOAL)):
        brush.ellipse((x - _DOT, y - _DOT, x + _DOT, y + _DOT), fill=colour)
    return picture


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
