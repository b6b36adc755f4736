"""Cells of areas with given outlines, for maps that are made of polygons."""

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from ppaas.maps.grid import GridInfo

Ring = NDArray[np.float64]
"""(n, 2) corners x, y [m]."""


def fill_area(mask: NDArray[np.bool_], info: GridInfo, ring: Ring, value: bool = True) -> None:
    """Set the cells of a mask whose centres are within a polygon, or on its outline.

    Parameters
    ----------
    mask : (height, width) bool array
        Row 0 is the lowest, as in a grid.
    info : GridInfo
        Geometry of the mask, not turned.
    ring : (n, 2) array
        Corners [m].
    value : bool
    """
    # The centre of a cell is the whole number of its pixel.
    cells = (ring - (info.origin.x, info.origin.y)) / info.resolution - 0.5
    low = np.maximum(np.floor(cells.min(axis=0)).astype(np.int64), 0)
    high = np.minimum(np.ceil(cells.max(axis=0)).astype(np.int64) + 1, (info.width, info.height))
    if not (low < high).all():
        return
    picture = Image.new("1", (high - low).tolist())
    ImageDraw.Draw(picture).polygon([(x, y) for x, y in (cells - low).tolist()], fill=1, outline=1)
    mask[low[1] : high[1], low[0] : high[0]][np.asarray(picture)] = value
