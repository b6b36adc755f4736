"""Costmaps as occupancy grids, as costmap_2d publishes them.

Source: ``Costmap2DPublisher`` of costmap_2d and nav2_costmap_2d, whose table of costs this is.
"""

import numpy as np

from ppaas.cost_values import FREE_SPACE, INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.costmap.costmap import Costmap
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap

MAX_CELLS = 1 << 20
"""Largest grid that `occupancy_of` returns; as JSON it has at most 4 MiB [cells]."""

_OCCUPANCY = np.empty(256, np.int8)
_OCCUPANCY[1:INSCRIBED_INFLATED_OBSTACLE] = 1 + 97 * np.arange(INSCRIBED_INFLATED_OBSTACLE - 1) // 251
_OCCUPANCY[FREE_SPACE] = FREE
_OCCUPANCY[INSCRIBED_INFLATED_OBSTACLE] = OCCUPIED - 1
_OCCUPANCY[LETHAL_OBSTACLE] = OCCUPIED
_OCCUPANCY[NO_INFORMATION] = UNKNOWN


def occupancy_of(costmap: Costmap, most: int = MAX_CELLS) -> GridMap:
    """Return a costmap as an occupancy grid: 0 free, 1 to 98 graded, 99 inscribed, 100 lethal, −1 unknown.

    A costmap of more than ``most`` cells becomes coarser: each cell then has the highest value of the k × k cells that
    it covers, with the smallest k that suffices. So it is unknown only if all of them are.
    """
    cells, info = _OCCUPANCY[costmap.data], costmap.info
    coarser = 1
    while -(-info.height // coarser) * -(-info.width // coarser) > most:
        coarser += 1
    if coarser == 1:
        return GridMap(cells, info)
    rows = np.maximum.reduceat(cells, np.arange(0, info.height, coarser), axis=0)
    cells = np.maximum.reduceat(rows, np.arange(0, info.width, coarser), axis=1)
    height, width = cells.shape
    return GridMap(cells, GridInfo(info.resolution * coarser, width, height, info.origin))
