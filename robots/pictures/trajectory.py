"""Picture of a map and the trajectory on which it was made."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import ImageDraw

from ppaas.maps.grid import GridMap
from robots.pictures.grid_image import GridImage
from robots.pictures.path import GOAL, PATH, START, check_picture

MOST = 4000
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
    draw(grid, poses).write(path)


def draw(grid: GridMap, poses: NDArray[np.float64]) -> GridImage:
    """Return the picture: the map with north up, the trajectory, a green dot at its start and a red one at its end.

    Parameters
    ----------
    grid : GridMap
        A wall in a reduced cell stays visible.
    poses : (n, 3) array
        x, y [m], theta [rad] in the map frame.
    """
    image = GridImage.of(grid, MOST)
    brush = ImageDraw.Draw(image.picture)
    points = image.pixels(poses[:, :2])
    brush.line(points, fill=PATH)
    for (x, y), colour in ((points[0], START), (points[-1], GOAL)):
        brush.ellipse((x - _DOT, y - _DOT, x + _DOT, y + _DOT), fill=colour)
    return image
