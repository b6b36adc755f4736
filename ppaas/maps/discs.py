"""Round things in a grid: robots and people."""

import math

import numpy as np
from numpy.typing import NDArray


def stamp_disc(cells: NDArray[np.uint8], x: float, y: float, radius: float, value: int) -> None:
    """Write ``value`` into the cells whose centre lies in a disc, and the one in which its middle lies.

    Parameters
    ----------
    cells : (height, width) uint8 array
        Written to; a disc may hang over its edge.
    x, y, radius : float
        In cells, from the corner of cell (0, 0); finite.
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
