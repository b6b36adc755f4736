"""Discs in a grid, for robots, people and round furniture."""

import math

import numpy as np
from numpy.typing import NDArray


def stamp_disc(cells: NDArray[np.uint8], x: float, y: float, radius: float, value: int) -> None:
    """Write a value into all cells whose centre is in a disc, and into the cell that contains the disc's centre.

    Parameters
    ----------
    cells : (height, width) uint8 array
        Modified in place; the disc may extend beyond it.
    x, y, radius : float
        Centre, from the corner of cell (0, 0), and radius of the disc [cells]; finite.
    value : int
        0 to 255.
    """
    height, width = cells.shape
    top, bottom = max(math.floor(y - radius), 0), min(math.ceil(y + radius), height)
    left, right = max(math.floor(x - radius), 0), min(math.ceil(x + radius), width)
    if top < bottom and left < right:
        rows = np.arange(top, bottom)[:, None] + 0.5 - y
        columns = np.arange(left, right) + 0.5 - x
        cells[top:bottom, left:right][rows * rows + columns * columns <= radius * radius] = value
    if 0 <= y < height and 0 <= x < width:
        cells[math.floor(y), math.floor(x)] = value
