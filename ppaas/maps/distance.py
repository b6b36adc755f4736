"""Distances of all cells from the nearest obstacle."""

import numpy as np
from numpy.typing import NDArray

from ppaas.maps.grid import OCCUPIED_THRESHOLD, GridMap
from ppaas.maps.kernels.distance import distance_parallel, distance_serial


def distance_to_occupied(
    grid: GridMap, threshold: int = OCCUPIED_THRESHOLD, *, serial: bool = False
) -> NDArray[np.float32]:
    """Return the exact Euclidean distance from the centre of each cell to the centre of the nearest occupied cell.

    It uses numba's current number of threads, or one if ``serial``.

    Parameters
    ----------
    grid : GridMap
        The map.
    threshold : int
        Cells of this occupancy or more are occupied; unknown cells are not.

    Returns
    -------
    (height, width) float32 array
        Distances [m]; 0 in occupied cells. If no cell is occupied, all are (height + width) · resolution, which exceeds
        any distance within the grid. Obstacles more than 65,534 cells away in a cell's own column are ignored.
    """
    occupied = np.ascontiguousarray(grid.data >= threshold).view(np.uint8)
    return (distance_serial if serial else distance_parallel)(occupied, grid.info.resolution)
