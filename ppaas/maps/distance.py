"""Distance from every cell to the nearest obstacle."""

import numpy as np
from numpy.typing import NDArray

from ppaas.maps.grid import OCCUPIED_THRESHOLD, GridMap
from ppaas.maps.kernels.distance import distance_parallel


def distance_to_occupied(grid: GridMap) -> NDArray[np.float32]:
    """Return the exact Euclidean distance between the centres of each cell and the nearest occupied one.

    It runs on as many threads as numba is set to.

    Parameters
    ----------
    grid : GridMap
        Cells of 65 or more are occupied; unknown ones are not.

    Returns
    -------
    (height, width) float32 array
        [m]; 0 where occupied. Where nothing in the grid is occupied, (height + width) · resolution, which is more
        than any distance within it. A cell with more than 65,534 free ones between it and the obstacles of its column
        counts as if there were none in it.
    """
    occupied = np.ascontiguousarray(grid.data >= OCCUPIED_THRESHOLD).view(np.uint8)
    return distance_parallel(occupied, grid.info.resolution)
