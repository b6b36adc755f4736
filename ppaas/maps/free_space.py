"""Free space of a map: distances of all cells from the nearest obstacle, and connected components."""

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.maps.grid import OCCUPIED_THRESHOLD, GridMap
from ppaas.maps.kernels.components import flood
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


def reachable(free: NDArray[np.bool_], row: int, column: int) -> NDArray[np.bool_]:
    """Return the cells that can be reached from a cell by moves to the eight neighbours.

    A diagonal move requires both adjacent cells to be free. Therefore diagonal moves reach no cell that moves along the
    axes do not.

    Parameters
    ----------
    free : (height, width) bool array
        Cells in which the centre of the robot may be.
    row, column : int
        Cell of the robot.

    Returns
    -------
    (height, width) bool array
        Reachable cells; all false if the robot's cell is not free.

    Raises
    ------
    InvalidMap
        ``free`` is not a two-dimensional array of bools.
    InvalidInput
        The cell is outside the grid.
    """
    if free.ndim != 2 or free.dtype != np.bool_:
        raise InvalidMap(f"expected a two-dimensional array of bools, not {free.dtype} of shape {free.shape}")
    height, width = free.shape
    if not (0 <= row < height and 0 <= column < width):
        raise InvalidInput(f"cell ({row}, {column}) is outside the grid of {height} rows and {width} columns")
    return flood(np.ascontiguousarray(free).view(np.uint8), row, column).view(np.bool_)
