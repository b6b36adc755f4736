"""Area of a map in which people can be: its free space. Reflections in mirrors and windows appear outside of it."""

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import LETHAL_OBSTACLE, NO_INFORMATION, Costmap
from ppaas.maps.free_space import distance_to_occupied
from ppaas.maps.grid import FREE, OCCUPIED, GridMap

Array = NDArray[np.float64]


class MapArea:
    """Free space of a map.

    Parameters
    ----------
    costmap : Costmap
        Its lethal cells and those without information are not free.
    """

    def __init__(self, costmap: Costmap) -> None:
        free = (costmap.data != LETHAL_OBSTACLE) & (costmap.data != NO_INFORMATION)
        self._info = costmap.info
        cells = np.where(free, OCCUPIED, FREE).astype(np.int8)
        self._distances = distance_to_occupied(GridMap(cells, costmap.info), serial=True)

    def distance(self, points: Array) -> Array:
        """Return the distance of (n, 2) points [m] from the free space, about [m]; 0 within it.

        For a point outside the map it is at most the nearest cell's plus the distance from there.
        """
        cells = self._info.to_cells(points)
        inside = np.clip(cells, 0, np.array(self._info.shape) - 1)
        beyond = self._info.resolution * np.hypot(*(cells - inside).T)
        return np.asarray(self._distances[inside[:, 0], inside[:, 1]] + beyond, np.float64)
