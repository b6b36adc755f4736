"""Free space of maps that show walls alone: what they enclose."""

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.maps.free_space import reachable
from ppaas.maps.grid import GridInfo

NEIGHBOURS = 5
"""Number of free neighbours of a cell, of eight, that make it free."""


def enclosed(
    occupied: NDArray[np.bool_], info: GridInfo, start: tuple[float, float] | None = None
) -> NDArray[np.bool_]:
    """Return the cells that are separated by walls from the border of a map.

    Parameters
    ----------
    occupied : (height, width) bool array
    info : GridInfo
    start : tuple of float, optional
        Only the cells around this place [m].

    Raises
    ------
    InvalidInput
        The place is outside the map, in an obstacle, or not within walls.
    """
    padded = np.pad(~occupied, 1, constant_values=True)
    if start is None:
        return np.asarray(~reachable(padded, 0, 0)[1:-1, 1:-1] & ~occupied)
    cell = info.cell_of(*start)
    place = f"x={start[0]:g}, y={start[1]:g}"
    if cell is None or occupied[cell]:
        raise InvalidInput(f"the free place {place} is {'outside of the map' if cell is None else 'in an obstacle'}")
    inside = reachable(padded, cell[0] + 1, cell[1] + 1)
    if inside[0, 0]:
        raise InvalidInput(
            f"the free place {place} is not within walls: close the gap in them, or choose a coarser resolution"
        )
    return np.asarray(inside[1:-1, 1:-1])


def closed_gaps(free: NDArray[np.bool_], occupied: NDArray[np.bool_], times: int = 2) -> NDArray[np.bool_]:
    """Return free cells and the cells among them: those of which most neighbours are free, twice."""
    for _ in range(times):
        padded = np.pad(free, 1).astype(np.uint8)
        height, width = free.shape
        count = np.zeros(free.shape, np.uint8)
        for row in range(3):
            for column in range(3):
                count += padded[row : row + height, column : column + width]
        free = free | ((count >= NEIGHBOURS) & ~occupied)
    return free
